"""The paper at its own pace: the calibration, an ensemble of learners and maps, its results."""
