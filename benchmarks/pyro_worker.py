"""Runs pyro2 on request; executed by the Python of pyro's own environment, so it imports nothing of hydro.

One JSON request a line on stdin, one JSON answer a line on stdout:

    {"do": "setup", "state": npy file, "gamma": g, "parameters": {...}}   -> {"versions": {...}}
    {"do": "steps", "count": k}                                           -> {"seconds": s}
    {"do": "until", "time": t}                                            -> {"seconds": s, "steps": k}
    {"do": "density", "file": npy file to write}                          -> {}

The state is (4, n, n): density, two momenta, total energy, on the periodic unit square.
"""

import json
import os
import sys
import time
from importlib.metadata import version

import numpy as np
from pyro import Pyro  # type: ignore[import-not-found]

WARM_UP = 2  # steps that compile everything
FIELDS = ("density", "x-momentum", "y-momentum", "energy")
SIDES = ("mesh.xlboundary", "mesh.xrboundary", "mesh.ylboundary", "mesh.yrboundary")
SETTINGS = {
    **dict.fromkeys(SIDES, "periodic"),
    "driver.tmax": 1e30,
    "driver.max_steps": 10**9,
    "driver.init_tstep_factor": 1.0,  # pyro's default starts at 1% of the CFL step
    "driver.verbose": 0,
    "io.do_io": 0,
    "vis.dovis": 0,
}


class Worker:
    """One pyro simulation at a time; each public method answers a request of that name."""

    warm = False  # whether its kernels are compiled

    def setup(self, state, gamma, parameters):
        """A new `compressible` simulation that starts from the state in the file; nothing is left to compile."""
        fields = np.load(state)
        n = fields.shape[1]
        inputs = {**SETTINGS, "mesh.nx": n, "mesh.ny": n, "eos.gamma": gamma, **parameters}
        self.start(fields, inputs)
        if not self.warm:
            self.steps(WARM_UP)
            self.start(fields, inputs)
            self.warm = True
        return {"versions": {name: version(name) for name in ("pyro-hydro", "numpy", "numba")}}

    def start(self, fields, inputs):
        """Make the simulation; a runtime parameter that pyro does not know raises KeyError."""
        self.pyro = Pyro("compressible")
        self.pyro.add_problem("given", lambda data, _: fill(data, fields))
        self.pyro.initialize_problem("given", inputs_dict=inputs)

    def steps(self, count):
        """Time `count` full time steps: ghost cells, time step, update."""
        start = time.perf_counter()
        for _ in range(count):
            self.pyro.single_step()
        return {"seconds": time.perf_counter() - start}

    def until(self, time):
        """Time all steps to the given time."""
        self.pyro.sim.tmax = time
        before, seconds = self.pyro.sim.n, 0.0
        while not self.pyro.sim.finished():
            seconds += self.steps(1)["seconds"]
        return {"seconds": seconds, "steps": self.pyro.sim.n - before}

    def density(self, file):
        """Write the density, ghost cells left out."""
        np.save(file, self.pyro.get_var("density").v())
        return {}


def fill(data, fields):
    """Put the fields into pyro's arrays."""
    for name, field in zip(FIELDS, fields, strict=True):
        data.get_var(name).v()[:, :] = field
    data.fill_BC_all()


def main():
    """Answer requests until stdin ends. Whatever pyro prints goes to stderr."""
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    worker = Worker()
    for line in sys.stdin:
        request = json.loads(line)
        print(json.dumps(getattr(worker, request.pop("do"))(**request)), file=answers, flush=True)


if __name__ == "__main__":
    main()
