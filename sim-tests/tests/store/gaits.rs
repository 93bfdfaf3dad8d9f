//! Several gaits in one robot.

