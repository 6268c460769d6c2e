"""The hacksaw once more, by a multibody engine that knows nothing of loop closures.

Source A drew the saw in a CAD system and let the simulation there move it. Exudyn takes that part here: three rigid
bodies, exact constraints between them, and an integrator. Of mechlib it is given the motion of the motor and no more.

python book/engine/hacksaw.py makes both tables anew: hacksaw.csv, the motion of the saw, and hacksaw_steps.csv, how far
it is from mechlib for ever smaller steps.

References
----------
Source A, sections 6.3 and 7.3, and appendix B.
"""

import sys
from pathlib import Path

import numpy as np

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

    The motor prescribes the angle of the crank, so that no freedom is left and masses do not matter. The integrator is
    the generalised-alpha method with the constraints on positions (index 3): the positions are as exact as its Newton
    iteration, the velocities and accelerations have an error of order two.

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
    import exudyn as exu  # here, so that the tables can be made use of without it
    from exudyn import itemInterface as item

    times, h = np.linspace(0, INSTANTS[-1], steps * (len(INSTANTS) - 1) + 1, retstep=True)
    theta2 = PROFILE.at(times).position
    container = exu.SystemContainer()
    saw = container.AddSystem()

    def body(x, y, angle):
        node = saw.AddNode(item.NodeRigidBody2D(referenceCoordinates=[x, y, angle]))
        return node, saw.AddObject(item.ObjectRigidBody2D(mass=1, inertia=1, nodeNumber=node))

    def point(body, x, y=0.0):
        return saw.AddMarker(item.MarkerBodyRigid(bodyNumber=body, localPosition=[x, y, 0]))

    def coordinate(node, which):
        return saw.AddMarker(item.MarkerNodeCoordinate(nodeNumber=node, coordinate=which))

    # Assembled at theta2 = 0, the slider to the left of the crank. A body is carried at O, A or B.
    reach = np.sqrt(R3**2 - R1Y**2)
    ground = saw.AddObject(item.ObjectGround())
    shaft, crank = body(0, 0, 0)
    pin, coupler = body(R2, 0, np.arctan2(R1Y, -reach))
    end, slider = body(R2 - reach, R1Y, 0)
    for first, second in (
        (point(ground, 0), point(crank, 0)),
        (point(crank, R2), point(coupler, 0)),
        (point(coupler, R3), point(slider, 0)),
    ):
        saw.AddObject(item.ObjectJointRevolute2D(markerNumbers=[first, second]))
    saw.AddObject(
        item.ObjectJointPrismatic2D(
            markerNumbers=[point(ground, 0, R1Y), point(slider, 0)], axisMarker0=[1, 0, 0], normalMarker1=[0, 1, 0]
        )
    )
    saw.AddObject(
        item.ObjectConnectorCoordinate(
            markerNumbers=[coordinate(saw.AddNode(item.NodePointGround()), 0), coordinate(shaft, 2)],
            offsetUserFunction=lambda saw, t, *_: theta2[round(t / h)],  # it is asked at the ends of steps only
        )
    )

    kind = exu.OutputVariableType
    sensors = [
        saw.AddSensor(
            item.SensorNode(nodeNumber=node, outputVariableType=output, storeInternal=True, writeToFile=False)
        )
        for node in (end, pin)
        for output in (kind.CoordinatesTotal, kind.Coordinates_t, kind.Coordinates_tt)
    ]
    saw.Assemble()

    settings = exu.SimulationSettings()
    settings.solution.file.write = False
    settings.solution.solverInformationFileName = ""
    settings.solution.sensors.writePeriod = 0  # every step
    integration = settings.timeIntegration
    integration.endTime, integration.numberOfSteps, integration.adaptiveStep = times[-1], len(times) - 1, False
    integration.generalizedAlpha.spectralRadius = 0
    integration.newton.useModifiedNewton = False
    integration.newton.relativeTolerance, integration.newton.absoluteTolerance = 1e-10, 1e-12
    saw.SolveDynamic(settings)

    read = [saw.GetSensorStoredData(sensor)[::steps, 1:] for sensor in sensors]
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


def write(path, comments, rows):
    """A table in which every number has all its digits."""
    lines = [f"# {comment}" for comment in comments] + [",".join(map(repr, row)) for row in rows]
    path.write_text("\n".join(lines) + "\n", encoding="utf8", newline="\n")


def main(folder: Path = HERE) -> None:
    """Write both tables."""
    try:
        import exudyn
    except ModuleNotFoundError:
        sys.exit("The engine, exudyn, is not installed: type make environment")

    engine = f"Exudyn {exudyn.__version__}, made by: python book/engine/hacksaw.py"
    interval = float(INSTANTS[1])
    write(
        folder / "hacksaw.csv",
        [
            engine,
            f"step of the integrator: {interval / STEPS!r} s, {STEPS} from one instant to the next",
            "time, then the nine quantities of the hacksaw",
            ", ".join(f"{name} [{unit}]" for name, unit in zip(["t", *QUANTITIES], ["s", *UNITS], strict=True)),
        ],
        np.column_stack((INSTANTS, simulate())).tolist(),
    )
    print(f"{folder / 'hacksaw.csv'}: Exudyn {exudyn.__version__}, {len(INSTANTS)} instants")
    write(
        folder / "hacksaw_steps.csv",
        [
            engine,
            "step of the integrator, then the largest error of each quantity against mechlib, in parts of its range",
            ", ".join(["h [s]", *QUANTITIES]),
        ],
        [[interval / steps, *row] for steps, row in zip(STUDIED, time_step_study().tolist(), strict=True)],
    )
    print(f"{folder / 'hacksaw_steps.csv'}: {len(STUDIED)} steps")


if __name__ == "__main__":
    main()
