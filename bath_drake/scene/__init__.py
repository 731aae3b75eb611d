"""The shower scene: person, arm, room, camera, and the numbers of it all."""
