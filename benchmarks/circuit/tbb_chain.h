#pragma once
// Peer for comparison: a chain of adders as a flow graph of oneTBB.

#include <memory>

namespace ugoki::benchmarks {

class TbbChain {
 public:
  explicit TbbChain(int n);
  ~TbbChain();
  TbbChain(const TbbChain&) = delete;
  TbbChain& operator=(const TbbChain&) = delete;
  double tick();  ///< sends 0 through the chain and returns its output; 0 if oneTBB is not installed

 private:
  struct Graph;
  std::unique_ptr<Graph> graph_;
};

}  // namespace ugoki::benchmarks
