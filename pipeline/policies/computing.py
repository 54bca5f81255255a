"""The machine that computes: its devices; threads, and memory that is kept over many batches."""

import ctypes
import platform
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import torch

CPU = torch.device("cpu")

# Of glibc's mallopt(3), and its defaults.
_TRIM_THRESHOLD, _TRIM_DEFAULT = -1, 128 * 1024
_MMAP_MAX, _MMAP_DEFAULT = -4, 65536


def find_device(name: str) -> torch.device:
    """The device of this name, as PyTorch names them: "cpu", "cuda", "cuda:1", "mps"; ValueError where
    this machine has none.
    """
    found = ["cpu"]
    accelerator = torch.accelerator.current_accelerator(check_available=True)
    if accelerator is not None:
        kind, count = accelerator.type, torch.accelerator.device_count()
        found += [kind, *(f"{kind}:{number}" for number in range(count))]
    if name not in found:
        raise ValueError(
            f"device is {name!r}, expected one that this machine has: {', '.join(found)}"
        )
    return torch.device(name)


@contextmanager
def computing(threads: int | None = None) -> Iterator[None]:
    """Keep freed memory for the next batch meanwhile, and compute with so many threads, if given.

    glibc hands each large tensor back to the system, which then has to clear its pages for the
    next: a third of the time of a training, half of that of inference. Without glibc there is
    nothing to keep it from.
    """
    before = torch.get_num_threads()
    torch.set_num_threads(threads or before)
    _mallopt({_MMAP_MAX: 0, _TRIM_THRESHOLD: 2**31 - 1})
    try:
        yield
    finally:
        _mallopt({_MMAP_MAX: _MMAP_DEFAULT, _TRIM_THRESHOLD: _TRIM_DEFAULT})
        torch.set_num_threads(before)


def processor() -> str:
    """Which one this is, as far as it decides how a network's sums are rounded."""
    about = Path("/proc/cpuinfo").read_text() if Path("/proc/cpuinfo").exists() else ""
    kind = re.findall(r"^(?:vendor_id|cpu family|model|stepping)\s*: (.+)$", about, re.MULTILINE)
    return " ".join([platform.machine(), *kind[:4], torch.backends.cpu.get_cpu_capability()])


def _mallopt(options: dict[int, int]) -> None:
    if sys.platform != "linux":
        return
    library = ctypes.CDLL(None)
    if hasattr(library, "gnu_get_libc_version"):
        for option, value in options.items():
            library.mallopt(option, value)
