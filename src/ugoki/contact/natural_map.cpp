#include "ugoki/contact/natural_map.h"

#include <algorithm>
#include <cmath>

#include "ugoki/contact/contact_law.h"

namespace ugoki::contact {

double roll_projection(const RowBlock& b, const double* p, const double* u, double metric, double normal, double* x) {
  const double radius = b.mu * std::max(0.0, normal);
  double square = 0;
  for (int r = 0; r < 3; ++r) {
    x[r] = p[r] - u[r] / metric;
    square += x[r] * x[r];
  }
  const double size = std::sqrt(square);
  if (size > radius)
    for (int r = 0; r < 3; ++r) x[r] *= radius / size;
  return radius > 0 ? size / radius : HUGE_VAL;
}

void NaturalMap::add(const RowBlock& b, double normal, const double* p, const double* u) {
  // An entry of the natural map is a velocity for a row that obeys an equation, and an impulse times `metric` for a row at its bound.
  const auto add_entry = [this](double metric, double change, bool at_bound) {
    const double f = metric * change;
    square += f * f;
    maximum = std::max(maximum, at_bound ? std::fabs(f) / augmentation : std::fabs(f));
  };
  const double metric = augmentation * b.B[0];
  switch (b.kind) {
    case RowKind::contact: {
      const double metric_t = augmentation * std::max(b.B[1], b.B[2]);
      const double x_n = std::max(0.0, p[0] - (u[0] + b.compliance * b.B[0] * p[0]) / metric), radius = b.mu * (x_n + b.impact_impulse);
      double x1 = p[1] - u[1] / metric_t, x2 = p[2] - u[2] / metric_t;
      const bool slides = x1 * x1 + x2 * x2 > radius * radius;
      clamp_to_disk(x1, x2, radius);
      add_entry(metric, p[0] - x_n, x_n <= 0);
      add_entry(metric_t, p[1] - x1, slides);
      add_entry(metric_t, p[2] - x2, slides);
      return;
    }
    case RowKind::limit: {
      const double x = p[0] - u[0] / metric;
      return add_entry(metric, p[0] - std::max(0.0, x), x <= 0);
    }
    case RowKind::grip:
      for (int r = 0; r < 3; ++r) add_entry(1, u[r], false);
      return;
    case RowKind::friction: {
      const double x = p[0] - u[0] / metric;
      return add_entry(metric, p[0] - std::clamp(x, -b.bound, b.bound), std::fabs(x) > b.bound);
    }
    case RowKind::roll: {
      double x[3];
      const bool slides = roll_projection(b, p, u, augmentation * b.size * b.size, normal, x) > 1;
      for (int r = 0; r < 3; ++r) add_entry(augmentation * b.size * b.size * b.lever, p[r] - x[r], slides);
      return;
    }
  }
}

namespace {

void find_contact_law(const RowBlock& b, double augmentation, const double* p, const double* u, LinearLaw& law) {
  const double soft = b.compliance * b.B[0], B_t = std::max(b.B[1], b.B[2]), metric = augmentation * B_t;
  const double x_n = std::max(0.0, p[0] - (u[0] + soft * p[0]) / (augmentation * b.B[0]));
  const double radius = b.mu * (x_n + b.impact_impulse);
  if (x_n > 0) law.G[0] = 1 / soft;
  if (!(radius > 0)) return;
  const double x1 = p[1] - u[1] / metric, x2 = p[2] - u[2] / metric, size = std::sqrt(x1 * x1 + x2 * x2);
  if (size <= radius) {
    law.c[1] = p[1];
    law.c[2] = p[2];
    law.G[4] = law.G[8] = 1 / (NaturalMap::regularization * B_t);
    return;
  }
  const double d1 = x1 / size, d2 = x2 / size;  // the friction impulse is mu (p_n + impact_impulse) d + q e with e = (-d2, d1)
  law.c[1] = b.mu * b.impact_impulse * d1;
  law.c[2] = b.mu * b.impact_impulse * d2;
  const double across = 1 / std::max(metric * (size / radius - 1), NaturalMap::regularization * B_t);
  law.G[3] = b.mu * d1 * law.G[0];
  law.G[6] = b.mu * d2 * law.G[0];
  law.G[4] = d2 * d2 * across;
  law.G[5] = law.G[7] = -d1 * d2 * across;
  law.G[8] = d1 * d1 * across;
  law.symmetric = law.G[0] == 0;
}

}  // namespace

void find_linear_law(const RowBlock& b, double augmentation, double normal, const double* p, const double* u, LinearLaw& law) {
  law = {{0, 0, 0}, {0, 0, 0, 0, 0, 0, 0, 0, 0}, true};
  const auto keep = [&](int row, double regularized) {  // u + regularized (p' - p) = 0
    law.c[row] = p[row];
    law.G[4 * row] = 1 / regularized;
  };
  switch (b.kind) {
    case RowKind::contact: return find_contact_law(b, augmentation, p, u, law);
    case RowKind::limit:
      if (p[0] - u[0] / (augmentation * b.B[0]) > 0) keep(0, NaturalMap::limit_regularization * b.B[0]);
      return;
    case RowKind::grip:
      for (int r = 0; r < 3; ++r) keep(r, NaturalMap::limit_regularization * b.size * b.size);
      return;
    case RowKind::friction: {
      const double x = p[0] - u[0] / (augmentation * b.B[0]);
      law.c[0] = std::clamp(x, -b.bound, b.bound);
      if (std::fabs(x) < b.bound) keep(0, NaturalMap::regularization * b.B[0]);
      return;
    }
    case RowKind::roll: {
      if (roll_projection(b, p, u, augmentation * b.size * b.size, normal, law.c) < 1)
        for (int r = 0; r < 3; ++r) keep(r, NaturalMap::regularization * b.B[r]);
      return;
    }
  }
}

}  // namespace ugoki::contact
