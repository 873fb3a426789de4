# For an IOC with asyn and StreamDevice, and the motor module for motor.db. The IOC's user is in the group of the socket.
epicsEnvSet("STREAM_PROTOCOL_PATH", "/usr/share/hystcan/epics")
drvAsynIPPortConfigure("HYSTCAN", "unix:///run/hystcan/hystcan-can0.sock")

dbLoadRecords("/usr/share/hystcan/epics/controller.db", "P=stage:,PORT=HYSTCAN")
dbLoadRecords("/usr/share/hystcan/epics/axis.db", "P=stage:,AXIS=x,PORT=HYSTCAN,LOW=-3,HIGH=34")
dbLoadRecords("/usr/share/hystcan/epics/motor.db", "P=stage:,M=m1,AXIS=x,LOW=-3,HIGH=34")

iocInit()
