"""The paper at its own pace: the calibration, its freeze, and the agents trained afterwards."""
