#!/usr/bin/python3
"""python_node.py INTERFACE COUNT: a node without any code of hystcan. It waits for COUNT frames without a time limit
and then returns each of them with inverted payload, one by one. It prints the received frames as IDENTIFIER#PAYLOAD, CAN
FD frames as IDENTIFIER##FLAGS PAYLOAD without the space: 1 for the bit-rate switch, 2 for the error state."""
import sys

import can

bus = can.Bus(interface="socketcan", channel=sys.argv[1], fd=True)
print("ready", flush=True)
received = []
while len(received) < int(sys.argv[2]):
    received.append(bus.recv())
for message in received:
    digits = 8 if message.is_extended_id else 3
    flags = f"#{message.bitrate_switch + 2 * message.error_state_indicator}" if message.is_fd else ""
    print(f"{message.arbitration_id:0{digits}X}#{flags}{message.data.hex().upper()}")
    bus.send(can.Message(arbitration_id=message.arbitration_id, is_extended_id=message.is_extended_id,
                         is_fd=message.is_fd, bitrate_switch=message.bitrate_switch,
                         error_state_indicator=message.error_state_indicator,
                         data=bytes(255 - byte for byte in message.data)))
bus.shutdown()
