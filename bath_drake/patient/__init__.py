"""The seated person as they truly are: mesh, skin, wounds and motion (pure).

Scene and verification build on this. Of the loop only `PatientMotion` may look in
here, for the motion it plays: what the robot knows comes from the camera.
"""
