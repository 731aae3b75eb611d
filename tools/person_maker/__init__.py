"""Makes seated people out of MakeHuman's data; run through `tools/make_people.py`."""
