#pragma once
// The fast kernels and the choice of their width at run time. Internal to dynamics/.
//
// One source (kernel_*.h, templates on the scalar) is compiled three times: for the plain processor, for AVX2 and for AVX-512.
// All give the same bits: the same operations in the same order, none fused. One instance runs as one number a step, with sines
// and cosines in lanes; a batch runs as many instances as a register holds.

#include <cstddef>
#include <span>

#include "ugoki/dynamics/link_program.h"

namespace ugoki::dynamics {

enum class SimdWidth : std::uint8_t { plain, avx2, avx512 };

/// Numbers of one kind lie `stride` apart: 1 for one instance, the lanes of a block for a batch.
/// Constant: that of a node, Real, or for twins one for each lane.
template <class Real, class Constant = Real>
struct KernelArguments {
  const NodeOrder* order;
  const NodeConstants<Constant>* constants;
  int nodes, slots, nv;
  const LinkPlace* links;
  int link_count;
  const int* angle_q;
  const double* angle_sign;
  int angles;
  double* sin = nullptr;  ///< of the angles, where they are known already; else null
  double* cos = nullptr;

  const Real* q;           ///< [nq]
  const Real* v;           ///< [nv]
  const Real* in;          ///< [nv] vdot or tau; null: zero
  const Real* external;    ///< [links * 6] wrenches about the world origin in world axes, angular first; null: none
  Real* out;               ///< [nv] tau or vdot
  Real gravity[3];         ///< m/s^2
  std::byte* scratch;      ///< scratch_size(), on a boundary of 64 bytes
  const int* entry_place;  ///< inertia matrix only: Workspace::entry_place
  std::ptrdiff_t stride;
};

/// Pairs of equal subtrees side by side, and the trunk that carries them: link_twins.h. Addresses of one call.
struct TwinArguments {
  static constexpr int most_pairs = 4;
  struct Pair {
    KernelArguments<double, LaneArray<double, 2>> a;  ///< q, v, in, out: in front of its scratch; the inertia matrix goes out at once
    double *q, *v, *in;                               ///< those of `a`, to be filled from the trunk's by `q_of`, `v_of`
    int nq;
    const int* q_of;  ///< [nq * 2]
    const int* v_of;  ///< [nv * 2]
    const int* node;  ///< [nodes * 2] of the whole program
    int base;         ///< node of the trunk that carries them
    int place;        ///< NodeOrder::twins of that node
    int force_begin;  ///< of the trunk's forces, where those of the pair begin
    bool first;       ///< of this base
  };
  KernelArguments<double> trunk;
  const int* trunk_node;  ///< [trunk.nodes] of the whole program
  int pair_count;
  int places;
  const int* angle_q;        ///< [angles] of all: the trunk's, then those of each pair; a multiple of 16
  const double* angle_sign;  ///< [angles]
  int angles;
  Pair pairs[most_pairs];
};

/// One width. `batch_*` run `lanes` instances that lie side by side; bit i of what they return: instance i is singular.
template <class Real>
struct BatchKernels {
  int lanes;
  void (*inverse)(const KernelArguments<Real>&);
  unsigned (*forward)(const KernelArguments<Real>&);
  /// q, v <- a semi-implicit step with the accelerations `in`, but not of the instances whose bit is set in `stays`.
  void (*step)(const KernelArguments<Real>&, Real* q, Real* v, Real dt, unsigned stays);
};

struct Kernels {
  void (*inverse)(const KernelArguments<double>&);
  bool (*forward)(const KernelArguments<double>&);  ///< false: singular
  void (*inertia)(const KernelArguments<double>&);  ///< `out`: chain rows
  void (*inverse_twins)(const TwinArguments&);      ///< without external wrenches
  bool (*forward_twins)(const TwinArguments&);
  void (*inertia_twins)(const TwinArguments&);
  /// s[i], c[i] = sine and cosine of x[i]. @param n a multiple of 8
  void (*sin_cos)(const double* x, double* s, double* c, int n);
  BatchKernels<double> in_double;
  BatchKernels<float> in_single;
};

/// Entries that the inertia matrix gathers before it writes them to their places.
inline constexpr int inertia_entries_at_once = 256;

/// Bytes of scratch that the kernels need for `instances` side by side.
[[nodiscard]] std::size_t scratch_size(const LinkProgram& program, std::size_t bytes_a_number, int instances);
[[nodiscard]] std::size_t scratch_size(int nodes, int nv, int slots, int angles, std::size_t bytes_a_number, int instances);
/// The address of the wrenches, or null where all are zero.
[[nodiscard]] const double* acting(std::span<const Vec6> external);

/// The widest that this processor has.
[[nodiscard]] SimdWidth widest_simd();
/// The kernels in use: those of widest_simd(), unless a test chose others.
[[nodiscard]] const Kernels& kernels();
/// For tests and measurements, before other threads run: makes kernels() use `width`. @return false where the processor or the build lacks
/// it
bool use_simd(SimdWidth width);

namespace plain {
extern const Kernels table;
}
#ifdef UGOKI_X86_WIDTHS
namespace avx2 {
extern const Kernels table;
}
namespace avx512 {
extern const Kernels table;
}
#endif

}  // namespace ugoki::dynamics
