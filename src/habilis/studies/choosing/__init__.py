"""Several tools lie about, and only one of them fits: what leads an agent to it?"""
