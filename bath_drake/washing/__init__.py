"""What washing comes to on the true skin: jet, sponge, what they covered."""
