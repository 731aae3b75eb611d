"""The learner of the paper, as it is written (Sec. III-C)."""
