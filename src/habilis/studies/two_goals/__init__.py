"""Two objects with a goal each: the empowerment of which of them helps to bring both home?"""
