#pragma once
// Tables of the fast kernels, and the choice of the SIMD width at run time. Internal to dynamics/.
//
// The source (kernel_*.h, templates on the scalar type) is compiled three times: for the baseline processor, for AVX2 and for AVX-512. All
// three versions give identical bits: the same operations in the same order, without fused multiply-add. A single instance is computed with
// scalars, except sines and cosines, which use SIMD lanes. A batch computes as many instances at once as fit in a register.

#include <cstddef>
#include <span>

#include "ugoki/dynamics/link_program.h"

namespace ugoki::dynamics {

/// Instruction set of a kernel table. plain: baseline of the target processor, for example SSE2 on x86-64.
enum class SimdWidth : std::uint8_t { plain, avx2, avx512 };

/// Inputs, outputs and scratch memory of one kernel call. Element i of q, v, in, external and out is at index i * stride.
/// @tparam Constant type of a node's constants: Real; for twins (link_twins.h) LaneArray, one value per lane
template <class Real, class Constant = Real>
struct KernelArguments {
  const NodeOrder* order;
  const NodeConstants<Constant>* constants;
  int nodes, slots, nv;
  const LinkAttachment* links;
  int link_count;
  const int* angle_q;
  const double* angle_sign;
  int angles;
  double* sin = nullptr;  ///< [angles] sines, if sines and cosines are already computed; else null
  double* cos = nullptr;

  const Real* q;           ///< [nq] coordinates
  const Real* v;           ///< [nv] velocities
  const Real* in;          ///< [nv] vdot or tau; null: zero
  const Real* external;    ///< [links * 6] wrenches about the world origin in world axes, angular first; null: none
  Real* out;               ///< [nv] tau or vdot
  Real gravity[3];         ///< m/s^2
  std::byte* scratch;      ///< scratch_size() bytes, aligned to 64 bytes
  const int* entry_index;  ///< inertia matrix only: Workspace::entry_index
  std::ptrdiff_t stride;   ///< 1 for one instance; lanes of a block for a batch
};

/// Arguments of a call with twins (link_twins.h): those of the trunk and of each pair of equal subtrees.
struct TwinArguments {
  static constexpr int max_pairs = 4;
  struct Pair {
    KernelArguments<double, LaneArray<double, 2>> a;  ///< q, v, in and out are two-lane arrays stored before a.scratch; for the inertia
                                                      ///< matrix, `out` is the mechanism's array
    double *q, *v, *in;                               ///< arrays of `a`; kernels fill them from those of `trunk`, indexed by q_of, v_of
    int nq;                                           ///< number of coordinates of one twin
    const int* q_of;                                  ///< [nq * 2] coordinate of the mechanism for each value in `q`
    const int* v_of;                                  ///< [nv * 2] DOF of the mechanism for each value in `v`
    const int* node;                                  ///< [nodes * 2] index in the LinkProgram of each node
    int base;                                         ///< node of the trunk to which the two twins are attached
    int twin_slot;                                    ///< NodeOrder::twin_slot of the node `base`
    int force_begin;                                  ///< index of the pair's first DOF in the trunk's force_dof (LinkTwins)
    bool first;                                       ///< true: the first of the pairs attached to this base
  };
  KernelArguments<double> trunk;
  const int* trunk_node;  ///< [trunk.nodes] index in the LinkProgram of each node
  int pair_count;
  int twin_slots;            ///< number of trunk nodes with twins
  const int* angle_q;        ///< [angles] index in q of each angle: the trunk's angles, then those of each pair
  const double* angle_sign;  ///< [angles] factor of each angle: 1 or -1; 0 for padding
  int angles;                ///< number of angles, padded to a multiple of 16
  Pair pairs[max_pairs];
};

/// Kernels for `lanes` instances that are stored side by side.
template <class Real>
struct BatchKernels {
  int lanes;
  void (*inverse)(const KernelArguments<Real>&);
  unsigned (*forward)(const KernelArguments<Real>&);  ///< returns bits: bit i is set if instance i is singular
  /// Semi-implicit Euler step of q and v with the accelerations `in`. Instances whose bit is set in `stays` do not change.
  void (*step)(const KernelArguments<Real>&, Real* q, Real* v, Real dt, unsigned stays);
};

/// All kernels of one SIMD width.
struct Kernels {
  void (*inverse)(const KernelArguments<double>&);
  bool (*forward)(const KernelArguments<double>&);  ///< returns false: singular inertia
  void (*inertia)(const KernelArguments<double>&);  ///< `out`: inertia matrix as chain rows (Workspace::chain)
  void (*inverse_twins)(const TwinArguments&);      ///< the *_twins kernels do not support external wrenches
  bool (*forward_twins)(const TwinArguments&);
  void (*inertia_twins)(const TwinArguments&);
  /// s[i], c[i] = sine and cosine of x[i]. @param n a multiple of 8
  void (*sin_cos)(const double* x, double* s, double* c, int n);
  BatchKernels<double> in_double;
  BatchKernels<float> in_single;
};

/// Number of inertia matrix entries that kernel_inertia.h collects before it writes them to the chain rows.
inline constexpr int inertia_entries_at_once = 256;

/// Bytes of scratch memory that the kernels need for `instances` instances side by side.
[[nodiscard]] std::size_t scratch_size(const LinkProgram& program, std::size_t bytes_a_number, int instances);
[[nodiscard]] std::size_t scratch_size(int nodes, int nv, int slots, int angles, std::size_t bytes_a_number, int instances);
/// Address of `external` as an array of [links * 6] values; null if all are zero or `external` is empty.
[[nodiscard]] const double* nonzero_wrenches(std::span<const Vec6> external);

/// Widest SIMD instruction set that this processor and build support.
[[nodiscard]] SimdWidth widest_simd();
/// The kernels in use: those of widest_simd(), unless use_simd() selected others.
[[nodiscard]] const Kernels& kernels();
/// Whether kernels() returns kernels for AVX2 or wider registers.
[[nodiscard]] bool uses_avx2();
/// Makes kernels() return the table of `width`. For tests and benchmarks only; call it before other threads use kernels().
/// @return false if the processor or the build does not support `width`; kernels() then does not change
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
