"""Measured traces: `sonopack trace`. read() takes files of other instruments, arrivals() picks with errors from the noise,
transfer() compares two traces, against() fits a computed signal."""
from .arrivals import Arrival, arrivals, line
from .read import Trace, read
from .transfer import Ratio, Response, against, transfer

__all__ = ["Arrival", "Ratio", "Response", "Trace", "against", "arrivals", "line", "read", "transfer"]
