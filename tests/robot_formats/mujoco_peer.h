#pragma once
// Opens MJCF files with the installed MuJoCo 2.2.2. The files use some newer MJCF elements and attributes, which this MuJoCo does not know.

#ifdef UGOKI_HAVE_MUJOCO
#include <mujoco/mujoco.h>

#include <functional>
#include <memory>
#include <pugixml.hpp>
#include <string>

namespace ugoki::robot_formats {

/// A model opened by MuJoCo, or the reason why it was refused.
struct PeerModel {
  std::unique_ptr<mjModel, void (*)(mjModel*)> model{nullptr, mj_deleteModel};
  std::unique_ptr<mjData, void (*)(mjData*)> data{nullptr, mj_deleteData};
  std::string why;  ///< MuJoCo's error message, if `model` is null
};

/// How a file is modified before MuJoCo opens it.
struct PeerOptions {
  bool strip_meshes = false;                                     ///< remove every mesh that is read from a file, and the geoms that use it
  std::function<std::string(const std::string& file)> stand_in;  ///< contents used for mesh files that do not exist
};

/// Opens a file as MuJoCo would if it knew the current MJCF. Includes are spliced in, frames and replicates are expanded with MuJoCo's own
/// functions, and sites of equalities become anchors. A joint with a range is limited (autolimits). Unknown attributes are removed one by
/// one. In the opened model, everything except rigid-body dynamics is disabled: contacts, joint limits, springs, dampers, friction, fluids,
/// actuators and equalities. Tests can enable equalities again (mjOption::disableflags).
[[nodiscard]] PeerModel open_with_mujoco(const std::string& path, const PeerOptions& options = {});
/// As open_with_mujoco(), for a text that is not stored in a file.
[[nodiscard]] PeerModel open_text_with_mujoco(const std::string& text, const PeerOptions& options = {});

}  // namespace ugoki::robot_formats
#endif
