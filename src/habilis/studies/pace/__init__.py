"""The paper at its own pace: what was calibrated, an ensemble of learners and maps, and what came of it."""
