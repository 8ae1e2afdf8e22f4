//! Lanes = scalar = reference bit by bit on all shapes and rims; windows have the bytes of the whole; graphs mean what the rules mean.

eyot_testing::conformance_suite!(eyot_testing::plants::variants, eyot_testing::plants::start);
