"""Client for the control socket of a running controller (docs/control_socket.md)."""
from __future__ import annotations

import json
import os
import pathlib
import socket
import stat
from types import TracebackType
from typing import Any


class Refused(RuntimeError):
    """Raised if the controller refuses a command; the text is the reason."""


def _is_of_this_user(folder: str) -> bool:
    try:
        found = os.lstat(folder)
    except OSError:
        return False
    return stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid() and not found.st_mode & 0o022


def _default_socket(interface: str) -> pathlib.Path:
    given = os.environ.get("RUNTIME_DIRECTORY", "").split(":")[0] or os.environ.get("XDG_RUNTIME_DIR")
    of_user = filter(_is_of_this_user, (f"/run/user/{os.getuid()}", f"/tmp/hystcan-{os.getuid()}"))
    for folder in (given, *of_user, "/run/hystcan"):
        if folder and os.path.exists(path := os.path.join(folder, f"hystcan-{interface}.sock")):
            return pathlib.Path(path)
    raise FileNotFoundError(f"control socket hystcan-{interface}.sock not found: check that the controller is running")


class Client:
    """A connection to a running controller.

    socket_path: path that the controller logs; default: found by the name of the interface. timeout_s: maximum wait
    for each answer, in seconds. Raises OSError if no controller is running.

    In a `with` block, an exception stops the stage: every axis ramps to its safe drive and the controller ends. Without
    an exception the stage continues unchanged.

    >>> with Client("/run/user/1000/hystcan-can0.sock") as stage:    # doctest: +SKIP
    ...     stage.go_to("x", 12.5)
    ...     stage.wait("x")
    12.5003
    """

    def __init__(self, socket_path: str | os.PathLike[str] | None = None, *, interface: str = "can0",
                 timeout_s: float = 10.0) -> None:
        self._timeout_s = timeout_s
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            self._socket.settimeout(timeout_s)
            self._socket.connect(os.fspath(socket_path or _default_socket(interface)))
        except BaseException:
            self._socket.close()
            raise
        self._received = b""

    def __enter__(self) -> Client:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        try:
            if kind is not None:
                self._stop_after_an_error()
        finally:
            self.close()

    def _stop_after_an_error(self) -> None:
        """Stop the controller over a new connection: this one may be in the middle of an answer."""
        try:
            fresh = Client(self._socket.getpeername(), timeout_s=self._timeout_s)
            try:
                fresh.stop()
            finally:
                fresh.close()
        except (OSError, Refused):
            pass  # the controller ended; the first error is the one to report

    def close(self) -> None:
        """Close the connection. The stage continues unchanged."""
        self._socket.close()

    def command(self, do: str, **arguments: Any) -> dict[str, Any]:
        """Send a command of docs/control_socket.md and return the answer.

        Raises Refused if the controller refuses the command, TimeoutError if it does not answer.
        """
        line = json.dumps({"do": do, **{name: value for name, value in arguments.items() if value is not None}})
        self._socket.sendall(line.encode() + b"\n")
        answer: dict[str, Any] = json.loads(self._line())
        if not answer["ok"]:
            raise Refused(answer["error"])
        return answer

    def _line(self) -> bytes:
        while b"\n" not in self._received:
            part = self._socket.recv(65_536)
            if not part:
                raise ConnectionError("the controller closed the connection: it has ended, or the command was too long")
            self._received += part
        line, self._received = self._received.split(b"\n", 1)
        return line

    def status(self) -> dict[str, Any]:
        """Return the newest cycle of every axis, counters, and the recording."""
        return self.command("status")

    def axis(self, axis: str) -> dict[str, Any]:
        """Return the newest cycle of one axis: state, position_um, drive, ... Raises KeyError for an unknown axis."""
        for each in self.status()["axes"]:
            if each["name"] == axis:
                return dict(each)
        raise KeyError(f"unknown axis {axis}")

    def settings(self) -> dict[str, Any]:
        """Return the present configuration."""
        return self.command("settings")

    def enable(self, axis: str | None = None) -> None:
        """Start the axis: from offline to tracking. axis: name; default: all axes."""
        self.command("enable", axis=axis)

    def disable(self, axis: str | None = None) -> None:
        """Ramp to the safe drive and switch off."""
        self.command("disable", axis=axis)

    def clear(self, axis: str | None = None) -> None:
        """Clear the latched fault."""
        self.command("clear", axis=axis)

    def go_to(self, axis: str, position_um: float) -> None:
        """Leave the reference and move to a position, in um."""
        self.command("go_to", axis=axis, position_um=position_um)

    def wait(self, axis: str, timeout_s: float = 30.0) -> float:
        """Wait until the axis is in position after its last move; return the position in um.

        The axis needs the table [axis.control.in_position].
        """
        self._socket.settimeout(timeout_s + self._timeout_s)
        try:
            return float(self.command("wait", axis=axis, timeout_s=timeout_s)["position_um"])
        finally:
            self._socket.settimeout(self._timeout_s)

    def resume(self, axis: str | None = None) -> None:
        """Follow the configured reference again."""
        self.command("resume", axis=axis)

    def set(self, axis: str, key: str, value: Any) -> list[dict[str, str]]:
        """Change a key of [axis.control]; return the changes."""
        changed: list[dict[str, str]] = self.command("set", axis=axis, key=key, value=value)["changed"]
        return changed

    def undo(self) -> None:
        """Undo the last change of a setting."""
        self.command("undo")

    def record(self, on: bool = True) -> pathlib.Path:
        """Begin a recorded run, or end it if `on` is False; return its folder."""
        return pathlib.Path(self.command("record", on=on)["run"])

    def stop(self) -> None:
        """Ramp every axis to its safe drive and end the controller."""
        self.command("stop")
