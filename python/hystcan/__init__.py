"""hystcan: hysteresis models of smart-material actuators, their identification, rehearsals, recorded runs, and the
control of a running stage.

Names carry their units: `time_s`, `position_um`. Arrays are float64. Errors are Python exceptions with the text that
`hystcan` prints. docs/python.md is the guide.
"""
import pathlib

from ._hystcan import Error, Identified, Memory, Model, Rehearsal, Run, __version__, identify, step_response, validate
from .client import Client, Refused

__all__ = ["Client", "Error", "Identified", "Memory", "Model", "Refused", "Rehearsal", "Run", "__version__", "identify",
           "shipped", "step_response", "validate"]


def shipped(name: str) -> pathlib.Path:
    """Return the path of a configuration or model that comes with hystcan.

    Raises FileNotFoundError if hystcan has no such file.

    >>> import hystcan
    >>> hystcan.shipped("piezo.toml").name
    'piezo.toml'
    """
    prefix = pathlib.Path(__file__).absolute().parents[4]
    for folder in (prefix / "share/hystcan", prefix / "config"):  # installed; in the source tree
        if (folder / name).is_file():
            return folder / name
    raise FileNotFoundError(f"{name}: not found among the files of hystcan; expected a name such as piezo.toml")
