// Rows of batches: nanoseconds per humanoid in a batch of 256 different states, compared with single calls of the peer.

#include "scenes.h"
#include "table.h"
#include "ugoki/dynamics/batch.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::benchmarks {
namespace {

template <class Real>
void batch(Table& table, const MechanismPtr& m, Peer* peer, const std::string& kind, double relative) {
  constexpr int count = 256;
  dynamics::BatchWorkspace<Real> b(*m, count);
  dynamics::Workspace ws(*m);
  std::vector<double> one(static_cast<std::size_t>(m->nv())), many(one.size());
  for (int i = 0; i < count; ++i) {
    const State s = lively_state(*m, i);
    b.set_state(i, s.q, s.v);
    b.set(b.tau, i, s.tau);
  }
  if (dynamics::calc_forward_dynamics(b, gravity) != 0) throw std::runtime_error("the batch is singular");
  for (int i = 0; i < count; ++i) {
    const State s = lively_state(*m, i);
    (void)dynamics::calc_forward_dynamics(*m, ws, s.q, s.v, s.tau, gravity, {}, one);
    b.get(b.vdot, i, many);
    require_same(many, one, relative, "batch of " + kind);
  }
  std::vector<std::function<void()>> functions{[&] { dynamics::calc_inverse_dynamics(b, gravity); },
                                               [&] { (void)dynamics::calc_forward_dynamics(b, gravity); }};
  if (peer != nullptr) {
    functions.push_back([&] { (void)peer->inverse(); });
    functions.push_back([&] { (void)peer->forward(); });
  }
  const std::vector<double> ns = measure(functions);
  const char* const tasks[] = {"inverse", "forward"};
  for (std::size_t k = 0; k < 2; ++k) {
    Row row{.row = std::string("humanoid batch ") + tasks[k] + ", " + kind, .ours_ns = ns[k] / count, .peer = {}};
    if (peer != nullptr) {
      row.peer = peer->name() + " (one, double)";
      row.peer_ns = ns[k + 2];
    }
    table.add(row);
  }
}

void batches(Table& table) {
  const MechanismPtr m = make_humanoid();
  const std::unique_ptr<Peer> peer = make_mujoco(plain(*m, lively_state(*m)));
  batch<double>(table, m, peer.get(), "double", 1e-9);
  batch<float>(table, m, peer.get(), "float", 1e-2);
}
const RowRegistration register_batches(300, batches);

}  // namespace
}  // namespace ugoki::benchmarks
