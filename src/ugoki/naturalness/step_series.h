#pragma once
// Values over one stance or one swing in constant memory, and the shape of a ground force. Plain data.

namespace ugoki::naturalness {

/// Means over equal time intervals since clear(). If all places are used, neighbours are merged, so that any duration fits.
struct StepSeries {
  static constexpr int room = 48;
  double count = 0;   ///< number of valid values
  double stride = 1;  ///< number of samples in one value
  double sum = 0, held = 0;
  double values[room] = {};

  void clear() { *this = {}; }
  void add(double value);
  [[nodiscard]] int size() const { return static_cast<int>(count); }
};

/// Low-pass filter with a Gaussian kernel, without delay. Outside of the series the values are 0, as is a ground force.
/// @param interval s, between two values @param sigma s, standard deviation of the kernel
void smooth(StepSeries& series, double interval, double sigma);

/// Shape of a vertical ground force F(t) over a stance: least-squares fit of A (cos(pi t / T) - q cos(3 pi t / T)), |t| < T / 2.
/// Source: Alexander, Jayes, Fourier analysis of forces exerted in walking and running (1980).
struct ForceShape {
  double humps = 0;     ///< q: above 1/9 the force has two humps, as in walking
  double residual = 0;  ///< rms deviation from the fit / mean force
  bool valid = false;   ///< false: fewer than 8 values, or no force
};
[[nodiscard]] ForceShape fit_force(const StepSeries& force);

}  // namespace ugoki::naturalness
