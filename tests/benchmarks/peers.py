"""The hacksaw along a motion in two other programs, each as its own examples do it; run in an environment of theirs.

python peers.py FILE R3 reads the angle, speed and acceleration of the crank at each point from FILE, and prints as JSON
for each program the seconds it takes, and position, velocity and acceleration of its slider along the guide.
"""

import json
import sys
import time
import warnings

import numpy as np

R1Y, R2 = 0.045, 0.075


def by_pylinkage(r3, theta2, omega2, alpha2):
    from pylinkage.actuators import Crank
    from pylinkage.components import Ground
    from pylinkage.dyads import RRPDyad
    from pylinkage.simulation import Linkage

    shaft, left, right = Ground(0, 0), Ground(-1, R1Y), Ground(1, R1Y)
    crank = Crank(shaft, R2, angular_velocity=1.0)
    slider = RRPDyad(crank.output, left, right, r3, x=-0.09, y=R1Y)
    linkage = Linkage([shaft, left, right, crank, slider])
    found = []
    for turn, omega, alpha in zip(np.diff(theta2, prepend=0.0), omega2, alpha2, strict=True):
        linkage.set_input_velocity(crank, omega, alpha)
        (step,) = linkage.step_with_derivatives(1, turn)
        found.append([quantity[-1][0] if quantity[-1] else np.nan for quantity in step])
    return np.array(found, dtype=float).T


def by_mechanism(r3, theta2, omega2, alpha2):
    from mechanism import Mechanism, Vector, get_joints

    O, A, B, C = get_joints("O A B C")
    crank, coupler = Vector((O, A), r=R2), Vector((A, B), r=r3)
    guide, slide = Vector((O, C), r=R1Y, theta=np.pi / 2), Vector((C, B), theta=np.pi)
    machine = Mechanism(
        vectors=(crank, coupler, guide, slide),
        origin=O,
        loops=lambda x, i: crank(i) + coupler(x[0]) - guide() - slide(x[1]),
        pos=theta2,
        vel=omega2,
        acc=alpha2,
        guess=([2.87, 0.09], [0.5, 0.5], [0.5, 0.5]),
    )
    machine.iterate()
    return -np.array([slide.pos.rs, slide.vel.r_dots, slide.acc.r_ddots])


def main(file: str, r3: str) -> None:
    warnings.simplefilter("ignore")  # where a loop cannot close, what they return is looked at
    crank, found = np.load(file), {}
    for name, program in (("pylinkage", by_pylinkage), ("mechanism", by_mechanism)):
        program(0.170, *crank[:, :2])  # its imports are its start, and not its work
        begin = time.perf_counter()
        try:
            slider = program(float(r3), *crank).tolist()
        except Exception as refusal:
            slider = f"{type(refusal).__name__}: {refusal}"
        found[name] = {"seconds": time.perf_counter() - begin, "slider": slider}
    print(json.dumps(found))


if __name__ == "__main__":
    main(*sys.argv[1:])
