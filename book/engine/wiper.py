"""The windscreen wiper once more, by a multibody engine that knows nothing of loop closures.

Exudyn is given five bars, seven exact joints, the weight and the friction.  For inverse dynamics it also has the motion
of the crank, and its joint forces and the torque of its motor are read; for direct dynamics it has a motor, and moves.
Of mechlib it has two numbers, those of the motor.

python book/engine/wiper.py makes the tables anew: wiper_inverse.csv, torque and joint forces over a turn;
wiper_run_up.csv and wiper_coasting.csv, two motions; and wiper_steps.csv, how far they are from mechlib for ever
smaller steps.

References
----------
Source B, inverse and direct dynamics.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from planar import Body, Model, engine, write

HERE = Path(__file__).parent


class Bar(NamedTuple):
    """Mass, moment of inertia about the centre of mass, and how far that is from the joint the bar hangs in."""

    mass: float
    inertia: float
    centre: float

    @classmethod
    def about_joint(cls, mass: float, inertia: float, centre: float) -> "Bar":
        """With the moment of inertia about that joint."""
        return cls(mass, inertia - mass * centre**2, centre)


R0, R1, R2, R3, R4, R5 = 0.245, 0.105, 0.220, 0.150, 0.300, 0.300  # m, source B: O-C, O-A, A-B, C-B, C-D, D-E
BARS = (
    Bar.about_joint(0.08821, 0.0003443403325, R1 / 2),  # source B's program: the crank, in O
    Bar.about_joint(0.17773, 0.002934475, R2 / 2),  # the coupler, in A
    Bar.about_joint(0.43452, 0.050703593, 0.29047),  # the first blade, in C
    Bar.about_joint(0.43758, 0.050773125, 0.28949),  # the second blade, in F
    Bar(0.24013, 0.00191677341, R5 / 2),  # the bar between them, in D
)
G = 9.81  # m/s^2
SPEED = 35 * 2 * np.pi / 60  # rad/s
TURN = 2 * np.pi / SPEED  # s
FRICTION = 4.5  # N
WIDTH = 0.01  # m/s, the speed below which friction fades in direct dynamics
# The same in inverse dynamics, where a leap does no harm but the crank starts from rest: at no angle of the table is a
# centre of mass slower than thirty times that.
SHARP = 1e-5
STALL = 30.0  # N m, torque of the motor at standstill

JOINTS = "OABCDEF"
DEGREES = 360
RUN_UP = (0.1, 100), (2.9, 290)  # s, and how many instants: in a twentieth of a second it has its speed
COASTING = 2.0, 100
STEPS = {"inverse": 8, "run_up": 40, "coasting": 200}  # of the integrator, from one point or instant to the next
COARSER = (8, 4, 2, 1)  # times as long steps, for the study
SPECTRAL_RADIUS = 0.9


def assembled(theta1: float) -> list[tuple[float, float, float]]:
    """Where each bar hangs, and its angle, at an angle of the crank: from the triangle A-C-B, with B above."""
    ax, ay = R1 * np.cos(theta1), R1 * np.sin(theta1)
    to_a = np.hypot(ax - R0, ay)
    theta3 = np.arctan2(ay, ax - R0) % (2 * np.pi) - np.arccos((to_a**2 + R3**2 - R2**2) / (2 * to_a * R3))
    bx, by = R0 + R3 * np.cos(theta3), R3 * np.sin(theta3)
    theta2 = np.arctan2(by - ay, bx - ax)
    return [
        (0.0, 0.0, theta1),
        (ax, ay, theta2),
        (R0, 0.0, theta3),
        (R0 + R5, 0.0, theta3),
        (R0 + R4 * np.cos(theta3), R4 * np.sin(theta3), 0.0),
    ]


def wiper(theta1: float, friction: float, width: float) -> tuple[Model, Body, list]:
    """The wiper at rest at an angle of the crank: the model, its crank, and the joints in the order of their names."""
    model = Model()
    bodies = []
    for (mass, inertia, centre), (x, y, angle) in zip(BARS, assembled(theta1), strict=True):
        body = model.body(x + centre * np.cos(angle), y + centre * np.sin(angle), angle, mass, inertia)
        model.weigh(body, G)
        bodies.append(body)
    crank, coupler, first, second, bar = range(5)

    def at(k, along):
        return model.point(bodies[k], along - BARS[k].centre)

    def fixed(x):
        return model.point(model.ground, x)

    pins = (
        (at(crank, 0), fixed(0)),
        (at(crank, R1), at(coupler, 0)),
        (at(coupler, R2), at(first, R3)),
        (at(first, 0), fixed(R0)),
        (at(first, R4), at(bar, 0)),
        (at(bar, R5), at(second, R4)),
        (at(second, 0), fixed(R0 + R5)),
    )
    joints = [model.revolute(*pin) for pin in pins]
    if friction:
        for k in (first, second):
            rub(model, bodies[k], friction, width)
    return model, bodies[crank], joints


def rub(model: Model, body: Body, friction: float, width: float) -> None:
    """Dry friction at a centre of mass, against its velocity; it fades as tanh(speed/width)."""
    from exudyn.utilities import CreateSymbolicUserFunction

    tanh, sqrt = model.exudyn.symbolic.tanh, model.exudyn.symbolic.sqrt

    def force(system, t, number, displacement, velocity, stiffness, damping, offset):
        vx, vy = velocity[0], velocity[1]
        speed = sqrt(vx * vx + vy * vy + 1e-60)  # not zero at rest
        size = friction * tanh(speed / width) / speed
        return [size * vx, size * vy, 0.0]

    ends = [model.point(model.ground, 0), model.point(body, 0)]
    connector = model.system.AddObject(model.item.ObjectConnectorCartesianSpringDamper(markerNumbers=ends))
    function = CreateSymbolicUserFunction(model.system, force, "springForceUserFunction", connector)
    model.system.SetObjectParameter(connector, "springForceUserFunction", function)
    model.system.variables[f"friction {connector}"] = function  # the engine does not keep it


def crank_angle(t: float) -> float:
    """From rest at minus half a turn to its speed at zero, in the time of one turn, and on at that speed."""
    p = t / TURN
    return 2 * np.pi * (2.5 * p**4 - 3 * p**5 + p**6 if p < 1 else p - 0.5) - np.pi


def inverse(steps: int = STEPS["inverse"], friction: float = 0.0) -> np.ndarray:
    """Torque and joint forces over a turn at 35 rpm, at every degree of the crank.

    The crank is brought to its speed before, so that the engine begins at rest and finds all velocities itself.

    Parameters
    ----------
    steps : int
        Steps of the integrator from one degree to the next.
    friction : float
        On each blade, N.

    Returns
    -------
    ndarray, shape (361, 15)
        M in N m, and the forces in O to F in N, x and y of each, on the body that is nearer to the motor.

    Raises
    ------
    ModuleNotFoundError
        If Exudyn is not installed.
    """
    model, crank, joints = wiper(-np.pi, friction, SHARP)
    drive = model.drive(crank, lambda t: crank_angle(t) + np.pi)
    for force in (drive, *joints):
        model.watch(force, "Force")
    torque, *forces = model.solve(2 * TURN, 2 * DEGREES * steps, SPECTRAL_RADIUS)
    # The torque that the engine has is the one on the ground.
    return np.hstack((-torque, *(force[:, :2] for force in forces)))[DEGREES * steps :: steps]


def run_up(stall_torque: float, no_load_speed: float, steps: int = STEPS["run_up"]) -> np.ndarray:
    """The motion from rest at zero that a motor makes against weight and friction.

    Parameters
    ----------
    stall_torque, no_load_speed : float
        N m, and rad/s: between them its torque falls along a straight line.
    steps : int
        Steps of the integrator from one instant to the next.

    Returns
    -------
    ndarray, shape (391, 3)
        Time, angle and angular velocity of the crank.
    """
    model, crank, _ = wiper(0.0, FRICTION, WIDTH)
    shaft = model.point(crank, 0)
    model.system.AddLoad(model.item.LoadTorqueVector(markerNumber=shaft, loadVector=[0, 0, stall_torque]))
    model.system.AddObject(
        model.item.ObjectConnectorCoordinateSpringDamper(
            markerNumbers=model.angle(crank), damping=stall_torque / no_load_speed
        )
    )
    model.watch(crank, "Coordinates", "Coordinates_t")
    found = [np.zeros((1, 3))]
    for seconds, instants in RUN_UP:
        times = np.linspace(model.time, model.time + seconds, instants + 1)
        found.append(np.column_stack((times, go_on(model, seconds, instants, steps)))[1:])
    return np.vstack(found)


def coasting(steps: int = STEPS["coasting"]) -> np.ndarray:
    """The motion without torque and friction, from 35 rpm at zero.

    The crank is driven there, and then let go.  Parameter and result are those of `run_up`; shape (101, 3).
    """
    model, crank, _ = wiper(-np.pi, 0.0, WIDTH)
    drive = model.drive(crank, lambda t: crank_angle(t) + np.pi)
    model.watch(crank, "Coordinates", "Coordinates_t")
    seconds, instants = COASTING
    model.solve(TURN, round(TURN / seconds * instants * steps), SPECTRAL_RADIUS)
    model.system.SetObjectParameter(drive, "activeConnector", False)
    turned, speed = go_on(model, seconds, instants, steps).T
    return np.column_stack((np.linspace(0, seconds, instants + 1), turned - np.pi, speed))


def go_on(model: Model, seconds: float, instants: int, steps: int) -> np.ndarray:
    """How far the crank has turned, and how fast it does, from now on at so many instants."""
    return np.column_stack([q[::steps, 2] for q in model.solve(seconds, instants * steps, SPECTRAL_RADIUS)])


def by_engine(motor: tuple[float, float], coarser: int = 1) -> dict[str, np.ndarray]:
    """The three tables, with steps so many times as long."""
    steps = {name: number // coarser for name, number in STEPS.items()}
    turn = [inverse(steps["inverse"], friction) for friction in (0.0, FRICTION)]
    return {
        "inverse": np.column_stack((np.linspace(0, 2 * np.pi, DEGREES + 1), *turn)),
        "run_up": run_up(*motor, steps["run_up"]),
        "coasting": coasting(steps["coasting"]),
    }


def through_mean() -> tuple[float, float]:
    """Stall torque and no-load speed of the motor that has, at 35 rpm, the mean torque of a turn with friction."""
    from mechlib.motor import Motor  # here, since the engine must do without
    from mechlib.wiper import Wiper

    mean = turn_by_mechlib(Wiper(), FRICTION)[:-1, 0].mean()
    motor = Motor.through(speed=SPEED, torque=float(mean), stall_torque=STALL)
    return motor.stall_torque, motor.no_load_speed


def turn_by_mechlib(machine, friction: float) -> np.ndarray:
    """What mechlib has for `inverse`."""
    from mechlib import dynamics
    from mechlib.batched import batched
    from mechlib.motion import Motion

    theta1 = np.linspace(0, 2 * np.pi, DEGREES + 1)
    uniform = Motion(theta1 / SPEED, theta1, np.full_like(theta1, SPEED), np.zeros_like(theta1))
    sweep = batched(machine, uniform, machine.position(0.0), tol=1e-12)
    velocities = (dynamics.trace(machine, sweep, centre).velocity for centre in ("G3", "G4"))
    loads = np.stack([dynamics.friction(v, friction) for v in velocities], axis=1)
    found = dynamics.inverse_dynamics(machine, sweep, loads)
    return np.column_stack((found.torque, *(found.forces[joint] for joint in JOINTS)))


def by_mechlib(motor: tuple[float, float], tables: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """What mechlib has for the three tables, at the same angles and instants."""
    from mechlib.direct import simulate
    from mechlib.motor import Motor
    from mechlib.motor import run_up as from_rest
    from mechlib.wiper import Wiper

    machine = Wiper()
    at = {name: table[:, 0] for name, table in tables.items()}
    moved = {
        "run_up": from_rest(machine, Motor(*motor), at["run_up"], FRICTION, WIDTH),
        "coasting": simulate(machine, lambda *_: 0.0, (0.0, SPEED), at["coasting"]),
    }
    motions = {name: np.column_stack((run.t, run.position[:, 0], run.velocity[:, 0])) for name, run in moved.items()}
    turn = [turn_by_mechlib(machine, friction) for friction in (0.0, FRICTION)]
    return {"inverse": np.column_stack((at["inverse"], *turn)), **motions}


def errors(found: dict[str, np.ndarray], expected: dict[str, np.ndarray]) -> dict[str, float]:
    """The largest error of each kind of quantity, in parts of its range; for the speed of the run-up, of 35 rpm."""
    off = {name: np.abs(found[name] - expected[name]).max(axis=0)[1:] for name in expected}
    span = {name: np.ptp(expected[name], axis=0)[1:] for name in expected}
    parts = {name: off[name] / span[name] for name in expected}
    free, rubbed = np.split(parts["inverse"], 2)
    return {
        "M without friction": free[0],
        "joint forces without friction": free[1:].max(),
        "M": rubbed[0],
        "joint forces": rubbed[1:].max(),
        "theta_1 running up": parts["run_up"][0],
        "omega_1 running up": off["run_up"][1] / SPEED,
        "theta_1 coasting": parts["coasting"][0],
        "omega_1 coasting": parts["coasting"][1],
    }


def main(folder: Path = HERE, finest: int = 1) -> None:
    """Write the tables, with steps so many times as long as in those that are kept."""
    version = engine()
    made_by = f"{version}, made by: python book/engine/wiper.py"
    motor = through_mean()
    expected, study = None, []
    for coarser in (c for c in COARSER if c >= finest):
        tables = by_engine(motor, coarser)
        expected = expected or by_mechlib(motor, tables)
        study.append([1 / coarser, *errors(tables, expected).values()])
    forces = [f"{joint}_{axis} [N]" for joint in JOINTS for axis in "xy"]
    moving = ["t [s]", "theta_1 [rad]", "omega_1 [rad/s]"]
    said = {
        "inverse": (
            "a turn at 35 rpm: torque of the motor and forces in the joints, without friction (free) and with it",
            ["theta_1 [rad]", *(f"{kind}{force}" for kind in ("free ", "") for force in ["M [N m]", *forces])],
        ),
        "run_up": (f"from rest by a motor of {motor[0]!r} N m at standstill and none at {motor[1]!r} rad/s", moving),
        "coasting": ("without torque and friction, from 35 rpm", moving),
    }
    for name, (what, columns) in said.items():
        of_steps = f"steps of the integrator, from one row to the next: {STEPS[name] // finest}"
        path = folder / f"wiper_{name}.csv"
        write(path, [made_by, of_steps, what, ", ".join(columns)], tables[name].tolist())
        print(f"{path}: {version}, {len(tables[name])} rows")
    path = folder / "wiper_steps.csv"
    what = "steps, in parts of those of the tables, then the largest errors against mechlib, in parts of the range"
    write(path, [made_by, what, ", ".join(["steps", *errors(expected, expected)])], np.array(study).tolist())
    print(f"{path}: {len(study)} steps")


if __name__ == "__main__":
    main()
