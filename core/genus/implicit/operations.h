#pragma once

#include <utility>

#include "genus/base/interval.h"
#include "genus/implicit/expression.h"

namespace genus {

/// The value of an operation. `number` is the exponent of a Power. Not-a-number goes through every
/// operation.
double operate(Operation operation, double a, double b, double number);

/// An interval that holds the values at all points where there is one.
struct Range {
    Interval values;
    bool may_be_undefined = false;  // not a number, at some points
};

/// Holds `operate` of all operands in the ranges, rounded as it rounds and exact: functions of the
/// standard library are taken to err by four units in the last place at most.
Range operate(Operation operation, const Range& a, const Range& b, double number);

/// Derivatives of the result by the operands. Where the operation has a crease that of one side,
/// which is the side that `operate` takes; where it jumps zero.
std::pair<double, double> derivatives(Operation operation, double a, double b, double number,
                                      double result);
/// Holds the derivatives on all sides of creases; unbounded where the operation may jump.
std::pair<Interval, Interval> derivatives(Operation operation, const Interval& a, const Interval& b,
                                          double number, const Interval& result);

/// Hold the second derivatives of a smooth operation by its operands; unbounded for the others, and
/// where the first may be.
struct SecondDerivatives {
    Interval aa, ab, bb;
};
SecondDerivatives second_derivatives(Operation operation, const Interval& a, const Interval& b,
                                     double number, const Interval& result);

/// x to a whole power, by multiplication.
double whole_power(double x, int n);

}  // namespace genus
