"""The ground above the hard base: a pile under each foot, or one soft layer, in Bullet."""

from __future__ import annotations

from collections.abc import Sequence

from gaitlab.simulation.bullet.world import WORLD_FRAME, BulletClient, add_plane, links
from gaitlab.surfaces.press import press
from gaitlab.surfaces.surface import SoftLayer
from gaitlab.surfaces.under_feet import UnderFeet

PARKED = -1.0  # m, where a tangent plane waits while its foot is in the air


def add_layer(client: BulletClient, surface: SoftLayer, supports: int) -> None:
    """A soft plane over the base; the stiffness of a sole is shared by its support points."""
    plane = add_plane(client, surface.height)
    # Bullet's stiffness and damping hold per contact point and only when given together.
    client.changeDynamics(
        plane,
        -1,
        contactStiffness=surface.stiffness / supports,
        contactDamping=surface.damping / supports,
    )


class PileUnderFeet:
    """A pile that pushes back on both feet, through one tangent plane a foot.

    Attributes:
        plough: Plough force on the left and the right foot in the last step, world x and y, [N].
        push: All that pushed them sideways beside Bullet's contacts, likewise.
    """

    def __init__(
        self, client: BulletClient, body: int, feet: Sequence[int], lawn: UnderFeet, *, dt: float
    ) -> None:
        """Takes Bullet's link indices of the feet, what is under them, and the step in [s]."""
        self._body, self._feet, self._lawn, self._dt = body, feet, lawn, dt
        self._planes = [_own_plane(client, body, foot) for foot in feet]
        self.plough = [(0.0, 0.0) for _ in feet]
        self.push = list(self.plough)
        self._link_states, self._move = client.getLinkStates, client.resetBasePositionAndOrientation
        self._soften = client.changeDynamics
        self._force, self._torque = client.applyExternalForce, client.applyExternalTorque

    def settle(self) -> float:
        """As of the lawn."""
        states = self._link_states(self._body, self._feet, 1, 1)
        return self._lawn.settle([(state[4], state[5]) for state in states])

    def press(self) -> None:
        """Set plane and plough force of each foot for the coming step."""
        # Without forward kinematics Bullet's link states are one step stale: negative damping.
        for side, state in enumerate(self._link_states(self._body, self._feet, 1, 1)):
            self._press(side, *state)

    def _press(
        self,
        side: int,
        centre: tuple[float, float, float],
        _turn: tuple[float, float, float, float],
        _local_centre: tuple[float, float, float],
        _local_turn: tuple[float, float, float, float],
        origin: tuple[float, float, float],
        quaternion: tuple[float, float, float, float],
        velocity: tuple[float, float, float],
        spin: tuple[float, float, float],
    ) -> None:
        plane, pile, footprint = (
            self._planes[side],
            self._lawn.piles[side],
            self._lawn.footprints[side],
        )
        support = press(pile, footprint, origin, quaternion, centre, velocity, spin, self._dt)
        self._move(plane, support.point, support.turn)
        self.plough[side], self.push[side] = support.plough, support.push
        if support.active:
            self._soften(
                plane, -1, contactStiffness=support.stiffness, contactDamping=support.damping
            )
        if support.push != (0.0, 0.0):
            foot = self._feet[side]
            self._force(self._body, foot, (*support.push, 0.0), centre, WORLD_FRAME)
            self._torque(self._body, foot, support.torque, WORLD_FRAME)


def _own_plane(client: BulletClient, body: int, foot: int) -> int:
    """A plane that only this foot meets."""
    plane = add_plane(client, PARKED)
    for link in links(client, body):
        if link != foot:
            client.setCollisionFilterPair(body, plane, link, -1, 0)
    return plane
