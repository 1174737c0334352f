"""Cases with known empowerment, and the evaluation of estimators on them."""
