# SPDX-License-Identifier: MIT
"""Threads, processes, interruption, and memory over many fits."""
import concurrent.futures
import gc
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from conftest import FORMULA

import silvafit as sf

#: Takes minutes, so that there is time to interrupt it.
LONG = """
import signal
# A job in the background ignores SIGINT unless it asks for it.
signal.signal(signal.SIGINT, signal.default_int_handler)
import numpy as np, silvafit as sf
random = np.random.default_rng(1)
dbh = random.uniform(5, 60, 200000)
plot = np.repeat(np.arange(20000), 10)
h = 1.3 + (30 + random.normal(0, 2, 20000)[plot]) * (1 - np.exp(-0.05 * dbh)) + random.normal(0, 1, 200000)
data = {"h": h, "dbh": dbh, "plot": plot}
print("ready", flush=True)
try:
    sf.fit("h ~ 1.3 + a*(1 - exp(-b*dbh))", data, random="a + b | plot", variance="power", method="agq",
           agq_points=40)
    print("finished", flush=True)
except KeyboardInterrupt:
    print("interrupted", flush=True)
# The interpreter goes on as usual.
print(sf.fit("h ~ a + b*dbh", {"h": h[:50], "dbh": dbh[:50]}).converged, flush=True)
"""


def test_ctrl_c_ends_a_fit():
    with subprocess.Popen([sys.executable, "-c", LONG], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          env=dict(os.environ)) as process:
        assert process.stdout.readline() == "ready\n"
        time.sleep(1.0)
        process.send_signal(signal.SIGINT)
        # A pass over the data may have to end first, on a busy machine.
        output, errors = process.communicate(timeout=120)
    assert output.split() == ["interrupted", "True"], errors


def test_other_threads_run_while_a_fit_does(stands):
    ticks = []
    done = threading.Event()

    def tick():
        while not done.wait(0.002):
            ticks.append(time.monotonic())

    thread = threading.Thread(target=tick)
    thread.start()
    begin = time.monotonic()
    sf.fit(FORMULA, stands, random="a + b | plot", variance="power", method="agq", starts=2)
    end = time.monotonic()
    done.set()
    thread.join()
    inside = [moment for moment in ticks if begin < moment < end]
    # With the GIL held there would be none.
    assert len(inside) > 3


def test_fits_in_threads_are_those_of_one_thread(stands):
    def one(plots):
        part = stands[stands["stand"].isin(plots)]
        return sf.fit(FORMULA, part, random="a | plot").to_json()

    names = sorted(stands["stand"].unique())
    jobs = [names[:4], names[4:], names[:6], names[2:]]

    def without_time(texts):
        return [text.split('"seconds"')[0] for text in texts]

    expected = without_time(map(one, jobs))
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        assert without_time(pool.map(one, jobs)) == expected


def _pearson(fit):
    return fit.residuals("pearson").to_numpy()


def test_fits_go_to_other_processes(mixed):
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        results = pool.map(_pearson, [mixed, mixed])
    for result in results:
        assert np.array_equal(result, _pearson(mixed))


def test_errors_and_warnings_in_other_processes(stands):
    error = None
    try:
        sf.fit(FORMULA, stands, random="a | nothing")
    except sf.Error as caught:
        error = caught
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        assert pool.apply(str, (error,)) == str(error)


def _resident():
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGESIZE")


def test_ten_thousand_fits_leave_no_memory():
    x = np.linspace(1.0, 10.0, 12)
    data = {"x": x, "y": 2.0 + 0.5 * x + 0.1 * np.sin(7 * x)}

    def fits(count):
        for _ in range(count):
            fit = sf.fit("y ~ a + b*x", data)
            fit.predict(data)
            fit.residuals()
        gc.collect()

    fits(1000)  # what is kept once
    objects = len(gc.get_objects())
    before = _resident()
    fits(9000)
    assert len(gc.get_objects()) - objects < 100
    # A fit of these rows has some kB, so that a leak of each would be above 30 MB.
    assert _resident() - before < 8e6


def test_failures_leave_no_references(stands):
    before = sys.getrefcount(stands)
    for _ in range(200):
        with pytest.raises(sf.Error):
            sf.fit(FORMULA, stands, random="a | nothing")
    gc.collect()
    assert sys.getrefcount(stands) <= before + 1


def test_progress_is_told_and_an_error_in_it_ends_the_work(mixed):
    from silvafit._analysis import analysis

    told = []

    def bootstrap(replicates, listener):
        analysis("bootstrap", mixed._frame.table, fits=[mixed._core], listener=listener, replicates=replicates, threads=2)

    bootstrap(20, lambda *message: told.append(message))
    assert told and told[-1][0] == "progress" and told[-1][3] == 20

    def fails(*_):
        raise RuntimeError("no more")

    with pytest.raises(RuntimeError, match="no more"):
        bootstrap(5000, fails)


def test_progress_by_tqdm(mixed, capsys):
    pytest.importorskip("tqdm")
    mixed.bootstrap(5, progress=True)
    assert "bootstrap" in capsys.readouterr().err
