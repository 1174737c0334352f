"""PushWorld once more, plainly: sets of cells that push each other, one state at a time.

Shares nothing with the bridge, its parser included.
"""

from hypothesis import strategies as st

DIRECTIONS = {"left": (0, -1), "right": (0, 1), "up": (-1, 0), "down": (1, 0)}


class SlowPuzzle:
    """A puzzle; a state maps each name, "A" or "M0" and so on, to a frozenset of cells."""

    def __init__(self, text, most_pushed=None):
        self.most_pushed = most_pushed
        things = {}
        grid = [line.split() for line in text.strip().splitlines()]
        self.size = len(grid), len(grid[0])
        for row, line in enumerate(grid):
            for column, cell in enumerate(line):
                for element in cell.upper().split("+"):
                    things.setdefault(element, set()).add((row, column))
        self.walls, self.own = things.get("W", set()), things.get("AW", set())
        self.goals = {"M" + name[1:]: cells for name, cells in things.items() if name[0] == "G"}
        names = sorted((name for name in things if name[0] == "M"), key=lambda name: int(name[1:]))
        self.start = {name: frozenset(things[name]) for name in ["A", *names]}

    def step(self, state, action):
        down, right = DIRECTIONS[action]
        after = dict(state)
        pending = ["A"]
        while pending:
            name = pending.pop()
            after[name] = frozenset((row + down, column + right) for row, column in state[name])
            if any(self.stops(name, cell) for cell in after[name]):
                return state
            for other, cells in state.items():
                if after[other] == state[other] and cells & after[name] and other != name:
                    pending.append(other)
        pushed = sum(after[name] != state[name] for name in state) - 1
        return state if self.most_pushed is not None and pushed > self.most_pushed else after

    def stops(self, name, cell):
        inside = 0 <= cell[0] < self.size[0] and 0 <= cell[1] < self.size[1]
        return not inside or cell in self.walls or (name == "A" and cell in self.own)

    def solved(self, state):
        return bool(self.goals) and all(state[name] == goal for name, goal in self.goals.items())

    def corner(self, state, name):
        return min(row for row, _ in state[name]), min(column for _, column in state[name])

    def corners(self, state):
        return [self.corner(state, name) for name in self.start]

    def reached(self, state, horizon):
        """The states after exactly so many actions."""
        there = {tuple(state.values())}
        for _ in range(horizon):
            states = (dict(zip(self.start, cells, strict=True)) for cells in there)
            there = {tuple(self.step(s, action).values()) for s in states for action in DIRECTIONS}
        return [dict(zip(self.start, cells, strict=True)) for cells in there]


@st.composite
def puzzles(draw):
    """Texts of small puzzles with an agent, M0, further movables, walls and sometimes a goal."""
    height, width = draw(st.integers(2, 5)), draw(st.integers(2, 6))
    cells = [(row, column) for row in range(height) for column in range(width)]
    kinds = [".", ".", ".", ".", "W", "AW", "A", "M0", "M1", "M2", "M1+AW", "m11"]
    grid = {cell: draw(st.sampled_from(kinds)) for cell in cells}
    grid[draw(st.sampled_from(cells))] = "a"
    others = [cell for cell in cells if grid[cell] != "a"]
    first = draw(st.sampled_from(others))
    grid[first] = "M0"
    body = [cell for cell in cells if grid[cell] == "M0"]
    down, right = draw(st.integers(-2, 2)), draw(st.integers(-2, 2))
    goal = [(row + down, column + right) for row, column in body]
    if all(grid.get(cell, "W") != "W" for cell in goal):
        for cell in goal:
            grid[cell] = "G0" if grid[cell] == "." else f"{grid[cell]}+G0"
    rows = (" ".join(grid[row, column] for column in range(width)) for row in range(height))
    return "\n".join(rows) + "\n"
