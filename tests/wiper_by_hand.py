"""Inverse dynamics of the wiper of source B, body by body in NumPy, without mechlib.

The plane is that of complex numbers.  `reactions` goes from the last bar of the chain to the crank, as one does by
hand, and solves no system of 15 equations; its keywords plant the mistakes of the source.  Two witnesses share nothing
with it: their accelerations, and the rate of the energy, are derivatives of Fourier series of the positions.
"""

from dataclasses import dataclass

import numpy as np

R0, R1, R2, R3, R4, R5 = 0.245, 0.105, 0.220, 0.150, 0.300, 0.300  # m
STRAIGHT_ON = 0.150  # m, B-D: r4 = r3 + a
G, OMEGA, RUBBING = 9.81, 35 * 2 * np.pi / 60, 4.5  # m/s^2, rad/s, N
TURN = np.linspace(0, 2 * np.pi, 361)


@dataclass(frozen=True)
class Bars:
    """Masses, centres of mass, and moments of inertia about the turning ends, as the program has them."""

    m: tuple = (0.08821, 0.17773, 0.43452, 0.43758, 0.24013)  # kg
    rg: tuple = (R1 / 2, R2 / 2, 0.29047, 0.28949, R5 / 2)  # m
    i: tuple = (0.0003443403325, 0.002934475, 0.050703593, 0.050773125)  # kg m^2


BARS = Bars()


def dot(u, v):
    return (u * v.conjugate()).real


def cross(u, v):
    return (u.conjugate() * v).imag


def turned(about, length, angle):
    """A point on a bar."""
    return about + length * np.exp(1j * angle)


def swung(angle, omega, alpha, length):
    """Velocity and acceleration of the end of a bar against its beginning."""
    arm = length * np.exp(1j * angle)
    return 1j * omega * arm, (1j * alpha - omega**2) * arm


def motion(th1=TURN):
    """Angles, angular velocities and angular accelerations of crank, coupler and blades, by the law of cosines."""
    a = turned(0, R1, th1)
    d = abs(R0 - a)
    b = a + R2 * (R0 - a) / d * np.exp(1j * np.arccos((R2**2 + d**2 - R3**2) / (2 * R2 * d)))
    th2, th3 = np.angle(b - a), np.angle(b - R0)
    e2, e3 = 1j * R2 * np.exp(1j * th2), 1j * R3 * np.exp(1j * th3)

    def split(z):
        """x, y with x e2 - y e3 + z = 0."""
        return -cross(e3, z) / cross(e3, e2), cross(e2, z) / cross(e2, e3)

    w2, w3 = split(1j * OMEGA * a)
    al2, al3 = split(-(OMEGA**2) * a + 1j * w2**2 * e2 - 1j * w3**2 * e3)
    constant = np.full_like(th1, OMEGA), np.zeros_like(th1)
    return (th1, *constant), (th2, w2, al2), (th3, w3, al3)


def friction(th, w, _, size=RUBBING):
    """On a blade, against its velocity."""
    return -size * np.sign(w) * 1j * np.exp(1j * th)


def friction_as_printed(th, w, _):
    v = np.sign(w) * 1j * np.exp(1j * th)
    x, y = (-RUBBING * np.sign(part) - part for part in (v.real, v.imag))
    return x + 1j * y


def reactions(bars=BARS, arm5=None, g5_on=R4, rub=friction, arm4=R4):
    """Torque and forces: each on the body that comes first in the chain crank, coupler, blades; E on the bar 5."""
    crank, coupler, blade = motion()
    (m1, m2, m3, m4, m5), (g1, g2, g3, g4, g5), (_, i2, i3, i4) = bars.m, bars.rg, bars.i
    arm5 = g5 if arm5 is None else arm5
    f3 = f4 = rub(*blade)
    lift = 1j * G
    a_A = swung(*crank, R1)[1]

    # bar 5 does not turn; its moments about D give E_y
    a5 = swung(*blade, g5_on)[1]
    E_y = m5 * arm5 * (G + a5.imag) / R5
    # blade 4 about F gives E_x
    th3, _, al3 = blade
    pull = i4 * al3 + cross(turned(0, g4, th3), m4 * lift - f4)
    E = (pull / arm4 + E_y * np.cos(th3)) / np.sin(th3) + 1j * E_y
    F = m4 * (swung(*blade, g4)[1] + lift) - f4 + E
    D = E - m5 * (a5 + lift)
    # blade 3 about C and the coupler about A give B
    th2, _, al2 = coupler
    across3 = i3 * al3 + cross(turned(0, g3, th3), m3 * lift - f3) - cross(turned(0, R4, th3), D)
    across2 = i2 * al2 + m2 * cross(turned(0, g2, th2), a_A + lift)
    e2, e3 = np.exp(1j * th2), np.exp(1j * th3)
    B = (across2 / R2 * e3 + across3 / R3 * e2) / cross(e2, e3)
    C = m3 * (swung(*blade, g3)[1] + lift) - f3 + B - D
    A = B - m2 * (a_A + swung(*coupler, g2)[1] + lift)
    O = m1 * (swung(*crank, g1)[1] + lift) - A
    th1 = crank[0]
    M = m1 * g1 * G * np.cos(th1) - cross(turned(0, R1, th1), A)
    return {"M": M, "O": O, "A": A, "B": B, "C": C, "D": D, "E": E, "F": F}


# --- witnesses


def rate(values):
    """Derivative by time of what repeats with every turn; the last point is the first again."""
    n = len(values) - 1
    modes = np.fft.fftfreq(n, 1 / n) * OMEGA
    found = np.fft.ifft(1j * modes * np.fft.fft(values[:-1]))
    return np.append(found, found[0])


def places(bars=BARS):
    """Joints and centres of mass."""
    (th1, *_), (th2, *_), (th3, *_) = motion()
    a, d = turned(0, R1, th1), turned(R0, R4, th3)
    joints = {"O": 0 * a, "A": a, "B": turned(R0, R3, th3), "C": 0 * a + R0, "D": d, "E": d + R5, "F": 0 * a + R0 + R5}
    g1, g2, g3, g4, g5 = bars.rg
    centres = turned(0, g1, th1), turned(a, g2, th2), turned(R0, g3, th3), turned(R0 + R5, g4, th3), d + g5
    return joints, centres, (th1, th2, th3, th3, None)


def about_centres(bars):
    """Moments of inertia about the centres of mass, by Steiner backwards."""
    return [i - m * r**2 for i, m, r in zip(bars.i, bars.m, bars.rg, strict=False)]


def torque_by_power(bars=BARS, rub=friction):
    """From the energies alone."""
    _, centres, angles = places(bars)
    energy = sum(m * (abs(rate(c)) ** 2 / 2 + G * c.imag) for m, c in zip(bars.m, centres, strict=True))
    for i, angle in zip(about_centres(bars), angles, strict=False):
        energy = energy + i * abs(rate(np.exp(1j * angle))) ** 2 / 2
    force = rub(*motion()[2])
    return (rate(energy).real - sum(dot(force, rate(c)) for c in centres[2:4])) / OMEGA


ENDS = ({"O": 1, "A": 1}, {"A": -1, "B": 1}, {"B": -1, "C": 1, "D": 1}, {"E": -1, "F": 1}, {"D": -1, "E": 1})


def imbalances(found, bars=BARS, rub=friction):
    """Of each bar, from the forces alone: what Newton leaves over, and Euler about the centre of mass."""
    joints, centres, angles = places(bars)
    force = rub(*motion()[2])
    left = []
    for k, (ends, centre, angle) in enumerate(zip(ENDS, centres, angles, strict=True)):
        given = force if k in (2, 3) else 0
        newton = sum(s * found[j] for j, s in ends.items()) + given - bars.m[k] * (rate(rate(centre)) + 1j * G)
        euler = sum(cross(joints[j] - centre, s * found[j]) for j, s in ends.items()) + (found["M"] if k == 0 else 0)
        if angle is not None:
            e = np.exp(1j * angle)
            euler = euler - about_centres(bars)[k] * rate((rate(e) / (1j * e)).real).real
        left.append((abs(newton).max(), abs(euler).max()))
    return np.array(left)


def span(values):
    return [values.min(), values.max()]
