"""Further tools and kinds of objects, as pictures before and after.

In the pictures the goal is unreachable. Each must hold turned and mirrored too: eight times.
"""

import pytest
from several import becomes, stays

SIDES = ("north", "east", "south", "west")
RAKE, STICK, MAGNET = "R = rake", "S = stick", "M = magnet"
BALL, CRATE = "C = ball", "C = crate"

# The rake


def test_a_rake_pulls_what_is_beyond_it_when_the_agent_backs_away():
    becomes("..ARC.   .ARC..", "west", above=RAKE)


def test_a_rake_pulls_nothing_that_is_out_of_line():
    becomes(
        """
        ..AR.   .AR..
        ...C.   ...C.
        """,
        "west",
        above=RAKE,
    )


def test_a_rake_pulls_nothing_that_is_one_cell_further():
    becomes("..AR.C   .AR..C", "west", above=RAKE)


def test_a_rake_is_not_carried_into_an_object():
    stays("ARC..", "east", above=RAKE)


def test_a_rake_carried_sideways_leaves_the_object():
    becomes(
        """
        ..C..   ..C..
        ..R..   ...R.
        ..A..   ...A.
        """,
        "east",
        above=RAKE,
    )


def test_a_rake_put_on_another_side_moves_nothing():
    becomes(
        """
        ....   .R..
        .ARC   .A.C
        """,
        "tool north",
        above=RAKE,
    )


# The stick: a broom two cells long


def test_a_stick_pushes_what_is_next_to_it():
    becomes(".ASC..   ..ASC.", "east", above=STICK)


def test_a_stick_pushes_what_its_end_comes_to():
    becomes(".AS.C..   ..AS.C.", "east", above=STICK)


def test_a_stick_leaves_alone_what_it_does_not_come_to():
    becomes(
        """
        .S.C.   ..SC.
        .A...   ..A..
        """,
        "east",
        above=STICK,
    )


def test_a_stick_carried_sideways_sweeps_with_its_end_too():
    becomes(
        """
        ..C..   ...C.
        .S...   ..S..
        .A...   ..A..
        """,
        "east",
        above=STICK,
    )


def test_the_end_of_a_stick_is_stopped_by_what_stops_the_object():
    stays(".AS.C#", "east", above=STICK)
    stays(".ASC#.", "east", above=STICK)


def test_the_end_of_a_stick_passes_over_walls():
    becomes(
        """
        ..#..   ..#..
        .S...   ..S..
        .A.C.   ..AC.
        """,
        "east",
        above=STICK,
    )


# The magnet


def test_a_magnet_draws_an_object_in_line_one_cell_closer():
    becomes("AM...C.   AM..C..", "tool east", above=MAGNET)


def test_a_magnet_draws_again_and_again_until_the_object_is_beside_it():
    becomes("AM...C.   AMC....", *["tool east"] * 5, above=MAGNET)


def test_a_magnet_draws_from_the_side_that_it_is_put_on():
    becomes(
        """
        .....   .....
        MA..C   .AMC.
        """,
        "tool east",
        above=MAGNET,
    )


@pytest.mark.parametrize("row", ["AM.#.C.", "AM#..C."])
def test_a_magnet_does_not_draw_through_a_wall(row: str):
    stays(row, "tool east", above=MAGNET)


def test_a_magnet_draws_nothing_out_of_line():
    stays(
        """
        AM....
        ...C..
        """,
        "tool east",
        above=MAGNET,
    )


def test_a_magnet_that_is_carried_draws_nothing():
    becomes(
        """
        .AM..C   AM...C
        """,
        "west",
        above=MAGNET,
    )
    stays("AMC...", "east", above=MAGNET)


def test_a_magnet_that_cannot_be_put_there_draws_nothing():
    stays(
        """
        .M..
        .A#C
        """,
        "tool east",
        above=MAGNET,
    )


# Balls


def test_a_ball_slides_until_a_wall_stops_it():
    becomes(".AC..#.   ..A.C#.", "east", above=BALL)


def test_a_ball_slides_to_the_edge_of_the_map():
    becomes(".AC.....   ..A....C", "east", above=BALL)


def test_a_ball_that_cannot_move_stops_the_agent():
    stays(".AC#..", "east", above=BALL)


def test_a_ball_swept_by_a_broom_slides():
    becomes(
        """
        .BC....   ..B...C
        .A.....   ..A....
        """,
        "east",
        above=BALL,
    )


def test_a_ball_in_a_picker_s_grip_does_not_slide():
    becomes(".APC....   ..APC...", "east", above=BALL)
    becomes(
        """
        ....   .C..
        ....   .P..
        .APC   .A..
        """,
        "tool north",
        above=BALL,
    )


def test_a_ball_that_is_pulled_by_a_rake_is_stopped_by_it():
    becomes("...ARC..   ..ARC...", "west", above=f"{RAKE}\n{BALL}")


def test_a_ball_that_is_drawn_by_a_magnet_comes_all_the_way():
    becomes("AM....C.   AMC.....", "tool east", above=f"{MAGNET}\n{BALL}")


# Crates


def test_a_crate_is_pushed_by_the_agent_and_by_brooms():
    becomes(".AC..   ..AC.", "east", above=CRATE)
    becomes(".ABC..   ..ABC.", "east", above=CRATE)
    becomes(".AS.C..   ..AS.C.", "east", above=f"{STICK}\n{CRATE}")


def test_a_crate_is_never_picked():
    stays(".APC..", "east", above=CRATE)
    becomes(".APC..   AP.C..", "west", above=CRATE)
    becomes(
        """
        ....   .P..
        .APC   .A.C
        """,
        "tool north",
        above=CRATE,
    )


def test_a_crate_is_neither_pulled_nor_drawn():
    becomes("..ARC.   .AR.C.", "west", above=f"{RAKE}\n{CRATE}")
    stays("AM..C.", "tool east", above=f"{MAGNET}\n{CRATE}")
