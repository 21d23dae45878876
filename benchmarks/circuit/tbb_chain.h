#pragma once
// The peer: a chain of adders as a flow graph of oneTBB.

#include <memory>

namespace ugoki::benchmarks {

class TbbChain {
 public:
  explicit TbbChain(int n);
  ~TbbChain();
  TbbChain(const TbbChain&) = delete;
  TbbChain& operator=(const TbbChain&) = delete;
  double tick();  ///< sends 0 through all of them; what comes out. 0 where oneTBB is not installed

 private:
  struct Graph;
  std::unique_ptr<Graph> graph_;
};

}  // namespace ugoki::benchmarks
