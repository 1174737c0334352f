"""A table with a puck, a wall and a far shelf, and a hand with its tools, as a MuJoCo model."""

from dataclasses import dataclass, fields

from habilis.empowerment.arguments import positive

NAME = "reach.xml"
"""The name of the built-in model where a file is asked for."""

_THICK = 0.05  # half of a wall around the table
_TOOL = 0.012  # the radius of a tool
_SPEED = 1.0  # m/s, of the hand
_STEP = 0.025  # s, of the simulation
# kg, of hand and puck. Servo and damping are so strong that both are at their speed, or at rest,
# after a single step.
_MASS, _LIGHT = 1.0, 0.2


@dataclass(frozen=True)
class Reach:
    """The dimensions of the world, in metres; x points right and y away from the robot.

    The hand starts near the robot in the middle, and can go as far as `reach`. Beyond a wall, which
    leaves the right part open, is a shelf. There is no gravity in the plane: the puck is pushed,
    and damping stops it. Contacts have no friction, so that a puck slips off a point that does not
    push through its centre.

    Attributes:
        side: of the table.
        radius: of the hand and of the puck.
        reach: the largest y of the hand's centre.
        tool: the length of each tool.
        bar: the length of the hook's bar, and the width of the scoop.
        wall: the y of the wall.
        opening: the width of the way past it.

    Raises:
        ValueError: a dimension is not above 0, or the hand can reach beyond the wall.

    Example:
        >>> Reach(tool=0.5).xml().count("<geom")
        15
    """

    side: float = 1.0
    radius: float = 0.04
    reach: float = 0.4
    tool: float = 0.4
    bar: float = 0.16
    wall: float = 0.6
    opening: float = 0.66

    def __post_init__(self) -> None:
        for field in fields(self):
            object.__setattr__(self, field.name, positive(field.name, getattr(self, field.name)))
        if self.reach + 3 * self.radius > self.wall or self.opening >= self.side:
            raise ValueError(
                f"reach is {self.reach:g}, wall {self.wall:g} and opening {self.opening:g}; leave "
                f"3 * radius between reach and wall, and an opening narrower than {self.side:g}"
            )

    def xml(self) -> str:
        """The model as MuJoCo reads it, with all tools in the hand: "stick", "hook" and "scoop".

        Returns:
            XML.
        """
        half, room = self.side / 2, self.side / 2 - self.radius
        length, bar = self.tool, self.bar
        fork = length - bar / 2
        prong = bar / 2
        shafts = (
            ("stick", (0, 0), (0, length)),
            ("hook", (0, 0), (0, length)),
            ("hook bar", (0, length), (-bar, length)),
            ("scoop", (0, 0), (0, fork)),
            ("scoop bar", (-prong, fork), (prong, fork)),
            ("scoop left", (-prong, fork), (-prong, length)),
            ("scoop right", (prong, fork), (prong, length)),
        )
        tools = "\n      ".join(
            f'<geom name="{name}" type="capsule" size="{_TOOL}" mass="0" '
            f'fromto="{x0:g} {y0:g} 0 {x1:g} {y1:g} 0"/>'
            for name, (x0, y0), (x1, y1) in shafts
        )
        out, thick, closed = half + _THICK, _THICK, self.side - self.opening
        walls = "\n    ".join(
            f'<geom name="{name}" type="box" pos="{x:g} {y:g} 0" size="{w:g} {d:g} 0.05"/>'
            for name, x, y, w, d in (
                ("left", -out, half, thick, half + 2 * thick),
                ("right", out, half, thick, half + 2 * thick),
                ("near", 0, -thick, half, thick),
                ("far", 0, self.side + thick, half, thick),
                ("wall", closed / 2 - half, self.wall, closed / 2, 0.02),
            )
        )
        start = 0.4 * self.reach
        return f"""<mujoco model="reach">
  <option timestep="{_STEP}" gravity="0 0 0" integrator="Euler">
    <flag eulerdamp="disable"/>
  </option>
  <default>
    <geom condim="1" solref="0.05 1" solimp="0.99 0.999 0.001"/>
    <joint solreflimit="0.05 1" solimplimit="0.99 0.999 0.001"/>
  </default>
  <custom>
    <numeric name="move" data="0.1"/>
    <numeric name="rest" data="{2 * _STEP:g}"/>
    <numeric name="resolution" data="0.05"/>
  </custom>
  <worldbody>
    {walls}
    <body name="hand" pos="0 {start:g} 0">
      <joint name="hand x" type="slide" axis="1 0 0" range="{-room:g} {room:g}"/>
      <joint name="hand y" type="slide" axis="0 1 0"
        range="{self.radius - start:g} {self.reach - start:g}"/>
      <geom name="hand" type="sphere" size="{self.radius:g}" mass="{_MASS:g}"/>
      {tools}
    </body>
    <body name="puck">
      <joint name="puck x" type="slide" axis="1 0 0" damping="{_LIGHT / _STEP:g}"
        range="{-room:g} {room:g}"/>
      <joint name="puck y" type="slide" axis="0 1 0" damping="{_LIGHT / _STEP:g}"
        range="{self.radius:g} {self.side - self.radius:g}"/>
      <geom name="puck" type="sphere" size="{self.radius:g}" mass="{_LIGHT:g}"/>
    </body>
  </worldbody>
  <actuator>
    <velocity joint="hand x" kv="{_MASS / _STEP:g}" ctrlrange="{-_SPEED:g} {_SPEED:g}"/>
    <velocity joint="hand y" kv="{_MASS / _STEP:g}" ctrlrange="{-_SPEED:g} {_SPEED:g}"/>
  </actuator>
</mujoco>
"""
