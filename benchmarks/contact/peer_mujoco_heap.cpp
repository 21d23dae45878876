#include "heap.h"

#ifdef UGOKI_HAVE_MUJOCO
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#endif

namespace ugoki::benchmarks {

#ifdef UGOKI_HAVE_MUJOCO
HeapResult run_mujoco_heap(const std::vector<HeapBody>& heap, double dt, int steps) {
  std::string xml = "<mujoco><option timestep=\"" + std::to_string(dt) +
                    "\"/><size nconmax=\"1500\" njmax=\"6000\"/><default><geom friction=\"0.9 0.005 0.0001\"/></default>"
                    "<worldbody><geom type=\"plane\" size=\"50 50 1\"/>";
  char text[512];
  for (const HeapBody& b : heap) {
    const char* type = b.shape == HeapShape::box       ? "box"
                       : b.shape == HeapShape::sphere  ? "sphere"
                       : b.shape == HeapShape::capsule ? "capsule"
                                                       : "cylinder";
    const double* q = b.orientation;
    std::snprintf(text, sizeof text,
                  "<body pos=\"%.17g %.17g %.17g\" quat=\"%.17g %.17g %.17g %.17g\"><freejoint/>"
                  "<geom type=\"%s\" size=\"%.17g %.17g %.17g\" density=\"%.17g\"/></body>",
                  b.position[0], b.position[1], b.position[2], q[0], q[1], q[2], q[3], type, b.size[0], b.size[1], b.size[2], b.density);
    xml += text;
  }
  xml += "</worldbody></mujoco>";
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  if (mj_makeEmptyFileVFS(files.get(), "heap.xml", static_cast<int>(xml.size())) != 0) return {};
  std::memcpy(files->filedata[mj_findFileVFS(files.get(), "heap.xml")], xml.data(), xml.size());
  char error[400] = "";
  mjModel* const model = mj_loadXML("heap.xml", files.get(), error, sizeof error);
  mj_deleteVFS(files.get());
  if (model == nullptr) return {};
  mjData* const data = mj_makeData(model);
  HeapResult result;
  for (int i = 0; i < steps; ++i) {
    mj_step(model, data);
    for (int k = 0; k < data->ncon; ++k) result.deepest = std::max(result.deepest, -data->contact[k].dist);
  }
  result.measured = data->time > 0.5 * dt * steps;  // MuJoCo restarts from time 0 if the simulation diverges
  mj_deleteData(data);
  mj_deleteModel(model);
  return result;
}
#else
HeapResult run_mujoco_heap(const std::vector<HeapBody>&, double, int) { return {}; }
#endif

}  // namespace ugoki::benchmarks
