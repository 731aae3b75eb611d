"""Where on a person's back the arm gets, and from where its base would do better.

Everything here knows the true person: it plans a run and judges it, and is no part of
the loop.
"""
