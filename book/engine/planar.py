"""What the scripts of the engine share: bodies in the plane as Exudyn has them, and tables with all digits."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np


class Body(NamedTuple):
    """By the numbers under which the engine has its coordinates and itself."""

    node: object
    number: object


class Model:
    """A mechanism of rigid bodies and exact joints, in the engine.

    Raises
    ------
    ModuleNotFoundError
        If Exudyn is not installed.
    """

    def __init__(self):
        import exudyn  # here, so that the tables can be made use of without it
        from exudyn import itemInterface

        self.exudyn, self.item = exudyn, itemInterface
        self.container = exudyn.SystemContainer()
        self.system = self.container.AddSystem()
        self.ground = Body(
            self.system.AddNode(itemInterface.NodePointGround()), self.system.AddObject(itemInterface.ObjectGround())
        )
        self.time, self._sensors = 0.0, []

    def body(self, x: float, y: float, angle: float, mass: float = 1.0, inertia: float = 1.0) -> Body:
        """With its centre of mass at a point, about which the moment of inertia is."""
        node = self.system.AddNode(self.item.NodeRigidBody2D(referenceCoordinates=[x, y, angle]))
        return Body(
            node, self.system.AddObject(self.item.ObjectRigidBody2D(mass=mass, inertia=inertia, nodeNumber=node))
        )

    def point(self, body: Body, x: float, y: float = 0.0):
        """A point of a body, from its centre and turning with it."""
        return self.system.AddMarker(self.item.MarkerBodyRigid(bodyNumber=body.number, localPosition=[x, y, 0]))

    def angle(self, body: Body) -> list:
        """By how much a body has turned on the ground, for what acts between the two."""
        return [
            self.system.AddMarker(self.item.MarkerNodeCoordinate(nodeNumber=node, coordinate=which))
            for node, which in ((self.ground.node, 0), (body.node, 2))
        ]

    def revolute(self, first, second):
        """A joint between two points; its force is the one on the first."""
        return self.system.AddObject(self.item.ObjectJointRevolute2D(markerNumbers=[first, second]))

    def prismatic(self, first, second):
        """A slide along the x axis of the first point's body, with which the second's keeps its angle."""
        return self.system.AddObject(
            self.item.ObjectJointPrismatic2D(
                markerNumbers=[first, second], axisMarker0=[1, 0, 0], normalMarker1=[0, 1, 0]
            )
        )

    def weigh(self, body: Body, g: float):
        """Give a body its weight, against the y axis."""
        weighed = self.system.AddMarker(self.item.MarkerBodyMass(bodyNumber=body.number))
        return self.system.AddLoad(self.item.LoadMassProportional(markerNumber=weighed, loadVector=[0, -g, 0]))

    def drive(self, body: Body, turned: Callable[[float], float]):
        """A motor that prescribes by how much a body is turned at a time, from where it was assembled."""
        return self.system.AddObject(
            self.item.ObjectConnectorCoordinate(
                markerNumbers=self.angle(body), offsetUserFunction=lambda system, t, *_: float(turned(t))
            )
        )

    def watch(self, what, *outputs: str) -> None:
        """Have outputs of a body's coordinates, or of a joint, returned by `solve`."""
        for output in outputs:
            options = {
                "outputVariableType": getattr(self.exudyn.OutputVariableType, output),
                "storeInternal": True,
                "writeToFile": False,
            }
            sensor = (
                self.item.SensorNode(nodeNumber=what.node, **options)
                if isinstance(what, Body)
                else self.item.SensorObject(objectNumber=what, **options)
            )
            self._sensors.append(self.system.AddSensor(sensor))

    def solve(self, seconds: float, steps: int, spectral_radius: float) -> list[np.ndarray]:
        """Let time go on, from where it was left.

        The integrator is the generalised-alpha method with the constraints on positions (index 3): the positions hold
        the joints as exactly as its Newton iteration, and the rest has an error of order two.

        Parameters
        ----------
        seconds : float
        steps : int
        spectral_radius : float
            0 to 1: how slowly what the steps cannot follow dies out.

        Returns
        -------
        list of ndarray, shape (steps + 1, components)
            What was asked for by `watch`, in that order, from the first instant to the last.
        """
        if not self.system.systemIsConsistent:
            self.system.Assemble()
        settings = self.exudyn.SimulationSettings()
        settings.solution.file.write = False
        settings.solution.solverInformationFileName = ""
        settings.solution.sensors.writePeriod = 0  # every step
        integration = settings.timeIntegration
        integration.startTime, integration.endTime = self.time, self.time + seconds
        integration.numberOfSteps, integration.adaptiveStep = steps, False
        integration.generalizedAlpha.spectralRadius = spectral_radius
        integration.newton.useModifiedNewton = False
        integration.newton.relativeTolerance, integration.newton.absoluteTolerance = 1e-10, 1e-12
        self.system.SolveDynamic(settings, updateInitialValues=True)
        self.time += seconds
        return [self.system.GetSensorStoredData(sensor)[:, 1:] for sensor in self._sensors]


def engine() -> str:
    """Its name and version; one sentence and the end, if it is not installed."""
    try:
        import exudyn
    except ModuleNotFoundError:
        sys.exit("The engine, exudyn, is not installed: type make environment")
    return f"Exudyn {exudyn.__version__}"


def write(path: Path, comments: list[str], rows: list[list[float]]) -> None:
    """A table in which every number has all its digits."""
    lines = [f"# {comment}" for comment in comments] + [",".join(map(repr, row)) for row in rows]
    path.write_text("\n".join(lines) + "\n", encoding="utf8", newline="\n")
