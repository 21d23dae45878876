#pragma once
// MJCF files opened by the installed MuJoCo 2.2.2, which knows an older dialect than the files speak.

#ifdef UGOKI_HAVE_MUJOCO
#include <mujoco/mujoco.h>

#include <functional>
#include <memory>
#include <pugixml.hpp>
#include <string>

namespace ugoki::robot_formats {

struct PeerModel {
  std::unique_ptr<mjModel, void (*)(mjModel*)> model{nullptr, mj_deleteModel};
  std::unique_ptr<mjData, void (*)(mjData*)> data{nullptr, mj_deleteData};
  std::string why;  ///< MuJoCo does not open it, in its words
};

/// How a file is rewritten before MuJoCo opens it.
struct PeerOptions {
  bool strip_meshes = false;                                     ///< take out every mesh that is a file, and the geoms that show it
  std::function<std::string(const std::string& file)> stand_in;  ///< content for mesh files that are not there
};

/// Opens the file as MuJoCo would if it knew today's MJCF: includes are spliced, frames and replicates composed with MuJoCo's
/// own functions, sites of equalities become anchors, limits are automatic, attributes it does not know are dropped one by one.
/// Everything but the rigid bodies is switched off: contacts, limits, springs, dampers, friction, fluids, drives; and
/// equalities, until a test wants them.
[[nodiscard]] PeerModel open_with_mujoco(const std::string& path, const PeerOptions& options = {});
/// The same with the text of a file that lies nowhere.
[[nodiscard]] PeerModel open_text_with_mujoco(const std::string& text, const PeerOptions& options = {});

}  // namespace ugoki::robot_formats
#endif
