"""The parts of `bath-drake bench perception`, a module each."""
