"""Pictures of learning, each to be read alone."""
