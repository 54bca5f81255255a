"""Drives in several processes."""

import sys
import warnings
from collections.abc import Callable, Generator, Iterable

from joblib import Parallel, delayed
from joblib.externals.loky.process_executor import TerminatedWorkerError


def in_order[Result](
    job: Callable[..., Result], arguments: Iterable[tuple], workers: int | None
) -> Generator[Result]:
    """Run `job(*arguments)` in `workers` processes, one for each core where None; the results come in
    the order of the arguments, as they are ready. OSError where the system killed one of them.
    """
    pool = Parallel(workers or -1, return_as="generator", batch_size=1, pre_dispatch="2 * n_jobs")
    results = pool(delayed(_on_one_thread)(job, each) for each in arguments)
    try:
        for result in results:  # noqa: UP028 (the warning below is given when `results` is closed)
            yield result
    except TerminatedWorkerError:
        raise OSError(
            "a worker process was killed, maybe for want of memory: try fewer workers"
        ) from None
    finally:
        with warnings.catch_warnings():
            # Whoever has enough stops early: what was begun beyond that is meant to be lost.
            warnings.simplefilter("ignore", UserWarning)
            results.close()


def _on_one_thread[Result](job: Callable[..., Result], arguments: tuple) -> Result:
    """Another number of threads may round differently, and then so would another number of workers."""
    if "torch" not in sys.modules:  # it takes seconds to import, and the reference needs none
        return job(*arguments)
    from pipeline.policies.computing import computing

    with computing(threads=1):
        return job(*arguments)
