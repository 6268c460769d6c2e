"""The hacksaw once more, by a multibody engine that knows nothing of loop closures.

Source A drew the saw in a CAD system and let the simulation there move it. Exudyn takes that part here: three rigid
bodies, exact constraints between them, and an integrator. Of mechlib it is given the motion of the motor and no more.

python book/engine/hacksaw.py makes both tables anew: hacksaw.csv, the motion of the saw, and hacksaw_steps.csv, how far
it is from mechlib for ever smaller steps.

References
----------
Source A, sections 6.3 and 7.3, and appendix B.
"""

from pathlib import Path

import numpy as np
from planar import Model, engine, write

from mechlib.motion import MotorProfile

HERE = Path(__file__).parent

R1Y, R2, R3 = 0.045, 0.075, 0.170  # m, source A section 5.2: height of the guide, crank, coupler
PROFILE = MotorProfile.through(2 * np.pi)
INSTANTS = np.linspace(0, 2 * PROFILE.T, 1000)
STEPS = 32  # of the integrator, from one instant to the next
STUDIED = (1, 2, 4, 8, 16, 32)

QUANTITIES = "r1 th1 th3 v_r w1 w3 a_r al1 al3".split()
UNITS = "m rad rad m/s rad/s rad/s m/s^2 rad/s^2 rad/s^2".split()


def simulate(steps: int = STEPS) -> np.ndarray:
    """The saw at the 1000 instants, as the engine moves it.

    The motor prescribes the angle of the crank, so that no freedom is left and masses do not matter.

    The jerk of the motor leaps where its acceleration has a corner. There the method's accelerations are wrong by
    order one, and its spectral radius says how slowly that dies out. With a radius of zero it takes two steps, and no
    instant sees it when there are more than four to an interval: the corners lie at instants, or halfway between two.

    Parameters
    ----------
    steps : int
        Steps of the integrator from one instant to the next.

    Returns
    -------
    ndarray, shape (1000, 9)
        r1, theta1, theta3, and their first and second time derivatives.

    Raises
    ------
    ModuleNotFoundError
        If Exudyn is not installed.
    """
    times, h = np.linspace(0, INSTANTS[-1], steps * (len(INSTANTS) - 1) + 1, retstep=True)
    theta2 = PROFILE.at(times).position
    saw = Model()

    # Assembled at theta2 = 0, the slider to the left of the crank. A body is carried at O, A or B.
    reach = np.sqrt(R3**2 - R1Y**2)
    crank = saw.body(0, 0, 0)
    coupler = saw.body(R2, 0, np.arctan2(R1Y, -reach))
    slider = saw.body(R2 - reach, R1Y, 0)
    for first, second in (
        (saw.point(saw.ground, 0), saw.point(crank, 0)),
        (saw.point(crank, R2), saw.point(coupler, 0)),
        (saw.point(coupler, R3), saw.point(slider, 0)),
    ):
        saw.revolute(first, second)
    saw.prismatic(saw.point(saw.ground, 0, R1Y), saw.point(slider, 0))
    saw.drive(crank, lambda t: theta2[round(t / h)])  # it is asked at the ends of steps only
    for body in (slider, coupler):
        saw.watch(body, "CoordinatesTotal", "Coordinates_t", "Coordinates_tt")

    read = [values[::steps] for values in saw.solve(times[-1], len(times) - 1, spectral_radius=0)]
    slider, coupler = read[:3], read[3:]
    of_line = polar(*(values[:, :2] for values in slider))
    of_coupler = [values[:, 2] for values in coupler]
    return np.stack([q for (r, th), th3 in zip(of_line, of_coupler, strict=True) for q in (r, th, th3)], axis=-1)


def polar(position, velocity, acceleration):
    """Length and angle of the line from O to B, and their derivatives, from the x and y of B.

    B is on the left, where the length is negative and the angle near zero, as in source A.
    """
    r1 = -np.hypot(*position.T)
    along = position / r1[:, None]
    across = np.stack((-along[:, 1], along[:, 0]), axis=-1)
    v_r, v_across = (velocity * along).sum(axis=1), (velocity * across).sum(axis=1)
    w1 = v_across / r1
    a_r = (acceleration * along).sum(axis=1) + r1 * w1**2
    al1 = ((acceleration * across).sum(axis=1) - 2 * v_r * w1) / r1
    return (r1, np.arctan2(along[:, 1], along[:, 0])), (v_r, w1), (a_r, al1)


def time_step_study() -> np.ndarray:
    """The errors of the engine against mechlib, for ever smaller steps.

    Returns
    -------
    ndarray, shape (len(STUDIED), 9)
        The largest error of each quantity over the 1000 instants, in parts of its range.
    """
    from mechlib.hacksaw import Hacksaw  # here, since the engine must do without
    from mechlib.sweep import consecutive

    swept = consecutive(Hacksaw(), PROFILE.at(INSTANTS), [-0.1, -0.5, 3.0], tol=1e-12)
    expected = np.hstack((swept.position, swept.velocity, swept.acceleration))
    errors = [np.abs(simulate(steps) - expected).max(axis=0) for steps in STUDIED]
    return np.array(errors) / np.ptp(expected, axis=0)


def main(folder: Path = HERE) -> None:
    """Write both tables."""
    version = engine()
    made_by = f"{version}, made by: python book/engine/hacksaw.py"
    interval = float(INSTANTS[1])
    write(
        folder / "hacksaw.csv",
        [
            made_by,
            f"step of the integrator: {interval / STEPS!r} s, {STEPS} from one instant to the next",
            "time, then the nine quantities of the hacksaw",
            ", ".join(f"{name} [{unit}]" for name, unit in zip(["t", *QUANTITIES], ["s", *UNITS], strict=True)),
        ],
        np.column_stack((INSTANTS, simulate())).tolist(),
    )
    print(f"{folder / 'hacksaw.csv'}: {version}, {len(INSTANTS)} instants")
    write(
        folder / "hacksaw_steps.csv",
        [
            made_by,
            "step of the integrator, then the largest error of each quantity against mechlib, in parts of its range",
            ", ".join(["h [s]", *QUANTITIES]),
        ],
        [[interval / steps, *row] for steps, row in zip(STUDIED, time_step_study().tolist(), strict=True)],
    )
    print(f"{folder / 'hacksaw_steps.csv'}: {len(STUDIED)} steps")


if __name__ == "__main__":
    main()
