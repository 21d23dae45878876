#include "tbb_chain.h"

#include <oneapi/tbb/flow_graph.h>
#include <oneapi/tbb/global_control.h>

#include <deque>

namespace ugoki::benchmarks {

namespace flow = tbb::flow;
using Node = flow::function_node<double, double>;

struct TbbChain::Graph {
  // One thread: a chain has no parallel work, and passing it between threads would only take time.
  tbb::global_control one{tbb::global_control::max_allowed_parallelism, 1};
  flow::graph graph;
  std::deque<Node> nodes;
  double out = 0;
};

TbbChain::TbbChain(int n) : graph_(std::make_unique<Graph>()) {
  for (int i = 0; i < n; ++i) {
    const bool last = i + 1 == n;
    graph_->nodes.emplace_back(graph_->graph, flow::unlimited, [g = graph_.get(), last](double x) {
      if (last) g->out = x + 1;
      return x + 1;
    });
    if (i > 0) flow::make_edge(graph_->nodes[static_cast<std::size_t>(i - 1)], graph_->nodes.back());
  }
}

TbbChain::~TbbChain() { graph_->graph.wait_for_all(); }

double TbbChain::tick() {
  graph_->nodes.front().try_put(0.0);
  graph_->graph.wait_for_all();
  return graph_->out;
}

}  // namespace ugoki::benchmarks
