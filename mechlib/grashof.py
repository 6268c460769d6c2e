"""Which bars of a four-bar linkage can turn all the way round: Grashof's rule."""

from typing import Literal

from mechlib import require

GrashofClass = Literal["crank-rocker", "rocker-crank", "double-crank", "double-rocker", "triple-rocker", "change-point"]


def grashof(ground: float, driver: float, coupler: float, follower: float) -> GrashofClass:
    """The class of a four-bar linkage.

    A bar turns all the way round if the shortest and the longest together are shorter than the other two. Which bar
    it is depends on where the shortest is.

    Parameters
    ----------
    ground, driver, coupler, follower : float
        Lengths, in any one unit; the driver and the follower are joined to the ground.

    Returns
    -------
    str
        "crank-rocker" or "rocker-crank" where the driver or the follower is the shortest bar and turns round;
        "double-crank" where the ground is, and both turn round; "double-rocker" where the coupler is, and neither does;
        "triple-rocker" where nothing turns round; "change-point" where the two sums are the same, and the linkage
        can lie flat and leave that position on either branch.

    Raises
    ------
    ValueError
        If a length is not a positive number, or one bar is longer than the other three together.

    References
    ----------
    Source B, section on the condition of Grashof.
    """
    bars = {"ground": ground, "driver": driver, "coupler": coupler, "follower": follower}
    require.positive(**bars)
    shortest, p, q, longest = sorted(bars.values())
    if longest >= shortest + p + q:
        name = max(bars, key=bars.__getitem__)
        raise ValueError(
            f"the {name} of {longest:g} must be shorter than the other bars together, {shortest + p + q:g}"
        )
    excess = (shortest + longest) - (p + q)
    if abs(excess) <= 4 * 2.0**-52 * (p + q):
        return "change-point"
    if excess > 0:
        return "triple-rocker"
    turning: dict[str, GrashofClass] = {
        "driver": "crank-rocker",
        "follower": "rocker-crank",
        "ground": "double-crank",
        "coupler": "double-rocker",
    }
    return turning[min(bars, key=bars.__getitem__)]
