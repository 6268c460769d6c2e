"""The mechanism with the hydraulic cylinder once more, by a multibody engine that knows nothing of loop closures.

Exudyn is given three bodies, three pins, the slide of the rod in the barrel, the weight, and where the piston is along
the slide; the force that it needs to keep the piston there is read, and those in the joints. Of mechlib it has nothing.

python book/engine/cylinder.py makes both tables anew: cylinder.csv, the forces over a period, and cylinder_steps.csv,
how far they are from mechlib for ever smaller steps.

References
----------
Source C, inverse dynamics.
"""

from pathlib import Path

import numpy as np
from planar import Model, engine, write

HERE = Path(__file__).parent

O2 = 0.25, -1.0  # m, source C: where the cylinder stands on the ground; O4 is the origin
B, L = 0.25, 0.4  # m: O4-A on the rocker, and the rod
CENTRES = 0.3, 0.2, 0.6  # m: of the barrel from O2, of the rod from the piston, of the rocker from O4
MASSES = 5.0, 2.0, 1.0  # kg
INERTIAS = 5.0 * 0.3**2 / 3, 2.0 * 0.4**2 / 12, 1.0 * 0.6**2 / 3  # kg m^2; the rocker's with its own mass
G = 9.80665  # m/s^2
MIDDLE, AMPLITUDE, PERIOD = 0.6, 0.02, 1.0  # m, m, s: of the stroke

INSTANTS = np.linspace(0, PERIOD, 201)
STEPS = 8  # of the integrator, from one instant to the next
STUDIED = (1, 2, 4, 8)
SPECTRAL_RADIUS = 0.5

QUANTITIES = "Q O2_x O2_y A_x A_y O4_x O4_y P_n".split()


def stroke(t: float) -> float:
    """From rest in the middle to the swing of source C, in the time of one period, and on with it.

    Up to the fourth no derivative leaps where the swing begins and is full: the integrator would ring for a while.
    """
    p = min(t / PERIOD, 1.0)
    return MIDDLE + AMPLITUDE * p**4 * (35 - 84 * p + 70 * p**2 - 20 * p**3) * np.sin(2 * np.pi * t / PERIOD)


def simulate(steps: int = STEPS) -> np.ndarray:
    """The forces over a period, at the 201 instants.

    The swing grows for a period before, so that the engine begins at rest and finds all velocities itself.

    Parameters
    ----------
    steps : int
        Steps of the integrator from one instant to the next.

    Returns
    -------
    ndarray, shape (201, 8)
        Q, positive where the cylinder pushes; the forces along x and y on the barrel at O2, on the rod at A, on the
        rocker at O4; and the force on the rod at the piston, across its line. All in N.

    Raises
    ------
    ModuleNotFoundError
        If Exudyn is not installed.
    """
    model = Model()
    # Assembled with the stroke in its middle, where the cylinder stands upright below the end of a level rocker.
    (x, y), (g2, g3, g4), upright = O2, CENTRES, np.pi / 2
    at = (x, y + g2, upright), (x, y + MIDDLE + g3, upright), (g4, 0.0, 0.0)
    barrel, rod, rocker = (model.body(*q, m, inertia) for q, m, inertia in zip(at, MASSES, INERTIAS, strict=True))
    for body in (barrel, rod, rocker):
        model.weigh(body, G)
    foot, piston = model.point(barrel, -g2), model.point(rod, -g3)
    pins = (
        (foot, model.point(model.ground, *O2)),
        (model.point(rod, L - g3), model.point(rocker, B - g4)),
        (model.point(rocker, -g4), model.point(model.ground, 0)),
    )
    joints = [model.revolute(*pin) for pin in pins]
    slide = model.prismatic(foot, piston)
    drive = model.system.AddObject(
        model.item.ObjectJointGeneric(
            markerNumbers=[foot, piston],
            constrainedAxes=[1, 0, 0, 0, 0, 0],  # along the barrel, and nothing else
            offsetUserFunction=lambda system, t, *_: [float(stroke(t)), 0, 0, 0, 0, 0],
        )
    )
    for joint in joints:
        model.watch(joint, "Force")
    for along in (drive, slide):
        model.watch(along, "ForceLocal")
    period = (len(INSTANTS) - 1) * steps
    *pins, pushed, guided = (force[period::steps, :2] for force in model.solve(2 * PERIOD, 2 * period, SPECTRAL_RADIUS))
    # The forces of drive and slide that the engine has are those on the barrel.
    return np.column_stack((-pushed[:, 0], *pins, -guided[:, 1]))


def by_mechlib() -> np.ndarray:
    """What mechlib has for `simulate`."""
    from mechlib.cylinder import Cylinder, Swing, newton_euler  # here, since the engine must do without

    cylinder = Cylinder()
    motion = cylinder.length(Swing(MIDDLE, AMPLITUDE, 1 / PERIOD).at(INSTANTS))
    Q, forces = newton_euler(cylinder, cylinder.sweep(motion))
    return np.column_stack((Q, forces["O2"], forces["A"], forces["O4"], forces["P"][:, 0]))


def errors(found: np.ndarray, expected: np.ndarray) -> np.ndarray:
    """The largest error of each quantity over the period, in parts of its range."""
    return np.abs(found - expected).max(axis=0) / np.ptp(expected, axis=0)


def main(folder: Path = HERE) -> None:
    """Write both tables."""
    version = engine()
    made_by = f"{version}, made by: python book/engine/cylinder.py"
    expected = by_mechlib()
    runs = {steps: simulate(steps) for steps in STUDIED}
    interval = float(INSTANTS[1])
    said = {
        "cylinder": (
            f"steps of the integrator, from one row to the next: {STEPS}",
            "a period: force of the cylinder, forces in the joints, and at the piston across the rod",
            ["t [s]", *(f"{name} [N]" for name in QUANTITIES)],
            np.column_stack((INSTANTS, runs[STEPS])),
        ),
        "cylinder_steps": (
            "step of the integrator, then the largest error of each quantity against mechlib, in parts of its range",
            ["h [s]", *QUANTITIES],
            np.array([[interval / steps, *errors(run, expected)] for steps, run in runs.items()]),
        ),
    }
    for name, (*comments, columns, rows) in said.items():
        path = folder / f"{name}.csv"
        write(path, [made_by, *comments, ", ".join(columns)], rows.tolist())
        print(f"{path}: {version}, {len(rows)} rows")


if __name__ == "__main__":
    main()
