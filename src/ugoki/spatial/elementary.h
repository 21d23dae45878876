#pragma once
// Elementary functions that give the same bits on every compiler, optimisation level and machine (including WebAssembly). They use
// only +, -, *, / and sqrt of IEEE 754 doubles and no fused multiply-add. Errors are below 2 units in the last place (tan, asin and
// acos: below 3) in the stated ranges. A NaN argument gives NaN.

namespace ugoki {

inline constexpr double pi = 3.14159265358979323846;

struct SinCos {
  double sin, cos;
};
/// Sine and cosine of x [rad]. Returns NaN unless |x| < 1e8: the argument reduction is exact only below that limit.
[[nodiscard]] SinCos sin_cos(double x);
[[nodiscard]] double sin(double x);
[[nodiscard]] double cos(double x);
[[nodiscard]] double tan(double x);
/// Angle [rad] of the point (x, y), in (-pi, pi]; atan2(0, 0) = 0.
[[nodiscard]] double atan2(double y, double x);
[[nodiscard]] double atan(double x);
/// asin and acos clamp their argument to [-1, 1].
[[nodiscard]] double asin(double x);
[[nodiscard]] double acos(double x);
/// e^x. Returns infinity for x above 709.78 and 0 for x below -745.2.
[[nodiscard]] double exp(double x);
/// Natural logarithm. Returns NaN for x < 0 and -infinity for x = 0.
[[nodiscard]] double log(double x);
/// x^y for x > 0; the error is 2 (1 + |y log x|) units in the last place.
[[nodiscard]] double pow(double x, double y);

}  // namespace ugoki
