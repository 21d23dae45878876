#include "mujoco_peer.h"

#ifdef UGOKI_HAVE_MUJOCO
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

namespace ugoki::robot_formats {
namespace {

namespace fs = std::filesystem;

void splice_includes(pugi::xml_node node, const fs::path& folder) {
  for (pugi::xml_node child = node.first_child(); child;) {
    pugi::xml_node next = child.next_sibling();
    if (std::string(child.name()) == "include") {
      pugi::xml_document other;
      other.load_file((folder / child.attribute("file").value()).c_str());
      splice_includes(other.document_element(), folder);
      for (const pugi::xml_node n : other.document_element().children()) node.insert_copy_before(n, child);
      node.remove_child(child);
    } else {
      splice_includes(child, folder);
    }
    child = next;
  }
}

struct Frame {
  mjtNum pos[3] = {0, 0, 0}, quat[4] = {1, 0, 0, 0};
};

std::vector<double> numbers(const char* text) {
  std::istringstream in(text);
  std::vector<double> out;
  for (double v; in >> v;) out.push_back(v);
  return out;
}

std::string text_of(const mjtNum* v, int n) {
  std::ostringstream out;
  out.precision(17);
  for (int i = 0; i < n; ++i) out << v[i] << " ";
  return out.str();
}

/// Rewrites <frame> and <replicate>, which MuJoCo 2.2.2 does not know, as elements with poses of their own.
class Lowering {
 public:
  explicit Lowering(pugi::xml_node root) : root_(root) {
    for (const pugi::xml_node c : root.children("compiler")) {
      if (c.attribute("angle")) degrees_ = std::string(c.attribute("angle").value()) != "radian";
      if (c.attribute("eulerseq")) order_ = c.attribute("eulerseq").value();
    }
  }

  void expand() {
    for (const pugi::xml_node w : root_.children("worldbody")) expand_in(w);
  }

 private:
  void turn(mjtNum quat[4], const std::vector<double>& angles) const {
    for (int i = 0; i < 3; ++i) {
      const char c = order_[static_cast<std::size_t>(i)];
      const bool fixed = c < 'a';
      mjtNum axis[3] = {0, 0, 0}, q[4], result[4];
      axis[fixed ? c - 'X' : c - 'x'] = 1;
      mju_axisAngle2Quat(q, axis, angles[static_cast<std::size_t>(i)] * (degrees_ ? mjPI / 180 : 1));
      mju_mulQuat(result, fixed ? q : quat, fixed ? quat : q);
      mju_copy4(quat, result);
    }
  }

  Frame frame_of(const pugi::xml_node node) const {
    Frame f;
    if (node.attribute("pos")) mju_copy3(f.pos, numbers(node.attribute("pos").value()).data());
    if (node.attribute("quat")) mju_copy4(f.quat, numbers(node.attribute("quat").value()).data());
    if (node.attribute("euler")) turn(f.quat, numbers(node.attribute("euler").value()));
    mju_normalize4(f.quat);
    return f;
  }

  static Frame times(const Frame& a, const Frame& b) {
    Frame out;
    mju_rotVecQuat(out.pos, b.pos, a.quat);
    mju_addTo3(out.pos, a.pos);
    mju_mulQuat(out.quat, a.quat, b.quat);
    return out;
  }

  void move(pugi::xml_node node, const Frame& by, const std::string& suffix) const {
    add_suffix(node, suffix);
    const Frame f = times(by, frame_of(node));
    const auto set = [&](const char* name, const std::string& value) {
      node.remove_attribute(name);
      node.append_attribute(name).set_value(value.c_str());
    };
    node.remove_attribute("euler");
    if (node.attribute("fromto")) {
      const std::vector<double> v = numbers(node.attribute("fromto").value());
      mjtNum ends[6];
      for (int e = 0; e < 2; ++e) {
        mju_rotVecQuat(ends + 3 * e, v.data() + 3 * e, by.quat);
        mju_addTo3(ends + 3 * e, by.pos);
      }
      set("fromto", text_of(ends, 6));
      return;
    }
    set("pos", text_of(f.pos, 3));
    set("quat", text_of(f.quat, 4));
  }

  static void add_suffix(pugi::xml_node node, const std::string& suffix) {
    if (node.attribute("name") && !suffix.empty()) node.attribute("name").set_value((node.attribute("name").value() + suffix).c_str());
    for (pugi::xml_node child : node.children()) add_suffix(child, suffix);
  }

  /// Inserts copies of the children of a <frame> or <replicate> before this element. Nested frames and replicates must be expanded first.
  void copy_out(pugi::xml_node holder, const Frame& by, const std::string& suffix) const {
    for (const pugi::xml_node child : holder.children()) {
      if (child.type() != pugi::node_element) continue;
      pugi::xml_node copy = holder.parent().insert_copy_before(child, holder);
      move(copy, by, suffix);
    }
  }

  void expand_in(pugi::xml_node node) const {
    for (pugi::xml_node child = node.first_child(); child;) {
      expand_in(child);
      pugi::xml_node next = child.next_sibling();
      const std::string kind = child.name();
      if (kind == "frame") copy_out(child, frame_of(child), "");
      if (kind == "replicate") {
        const int count = child.attribute("count").as_int();
        const std::vector<double> offset =
            child.attribute("offset") ? numbers(child.attribute("offset").value()) : std::vector<double>(3, 0);
        const std::vector<double> euler = child.attribute("euler") ? numbers(child.attribute("euler").value()) : std::vector<double>(3, 0);
        Frame f;
        for (int i = 0; i < count; ++i) {
          const mjtNum none[4] = {1, 0, 0, 0};
          mju_copy4(f.quat, none);
          turn(f.quat, {i * euler[0], i * euler[1], i * euler[2]});
          std::string number = std::to_string(i);
          number.insert(0, std::to_string(count).size() - number.size(), '0');
          copy_out(child, f, child.attribute("sep").value() + number);
          mjtNum step[3];
          mju_rotVecQuat(step, offset.data(), f.quat);
          mju_addTo3(f.pos, step);
        }
      }
      if (kind == "frame" || kind == "replicate") node.remove_child(child);
      child = next;
    }
  }

  pugi::xml_node root_;
  bool degrees_ = true;
  std::string order_ = "xyz";
};

/// The first element of this kind and name.
pugi::xml_node with_name(pugi::xml_node node, const char* kind, const std::string& name) {
  return node.find_node([&](pugi::xml_node n) { return std::string(n.name()) == kind && n.attribute("name").value() == name; });
}

std::string body_of_site(pugi::xml_node root, const std::string& site) {
  const pugi::xml_node parent = with_name(root, "site", site).parent();
  return std::string(parent.name()) == "worldbody" ? "world" : parent.attribute("name").value();
}

/// An equality between sites, rewritten as one between bodies. Its data are set after loading.
struct SiteEquality {
  int index;
  bool weld;
  std::string site1, site2;
};

std::vector<SiteEquality> lower_equalities(pugi::xml_node root) {
  std::vector<SiteEquality> out;
  int index = 0, bodies = 0;
  for (pugi::xml_node section : root.children("equality"))
    for (pugi::xml_node e : section.children()) {
      if (e.type() != pugi::node_element) continue;
      if (e.attribute("site1")) {
        const SiteEquality s{index, std::string(e.name()) == "weld", e.attribute("site1").value(), e.attribute("site2").value()};
        for (const char* site : {"site1", "site2"}) {  // the rewritten equality refers to bodies by name
          pugi::xml_node parent = with_name(root, "site", e.attribute(site).value()).parent();
          if (std::string(parent.name()) == "body" && !parent.attribute("name"))
            parent.append_attribute("name").set_value(("peer_body_" + std::to_string(++bodies)).c_str());
        }
        e.remove_attribute("site1");
        e.remove_attribute("site2");
        // body1 is the body of site1, body2 the body of site2
        e.append_attribute("body1").set_value(body_of_site(root, s.site1).c_str());
        e.append_attribute("body2").set_value(body_of_site(root, s.site2).c_str());
        if (!s.weld) e.append_attribute("anchor").set_value("0 0 0");
        out.push_back(s);
      }
      ++index;
    }
  return out;
}

void set_equality_data(mjModel* m, const SiteEquality& e) {
  mjtNum* data = m->eq_data + mjNEQDATA * e.index;
  const int s1 = mj_name2id(m, mjOBJ_SITE, e.site1.c_str()), s2 = mj_name2id(m, mjOBJ_SITE, e.site2.c_str());
  mju_copy3(data + (e.weld ? 3 : 0), m->site_pos + 3 * s1);
  mju_copy3(data + (e.weld ? 0 : 3), m->site_pos + 3 * s2);
  if (!e.weld) return;
  mjtNum back[4];
  mju_negQuat(back, m->site_quat + 4 * s2);
  mju_mulQuat(data + 6, m->site_quat + 4 * s1, back);
}

void remove_meshes(pugi::xml_node node) {
  for (pugi::xml_node child = node.first_child(); child;) {
    pugi::xml_node next = child.next_sibling();
    const std::string kind = child.name();
    const bool of_file = (kind == "mesh" || kind == "texture" || kind == "skin") && child.attribute("file");
    if (of_file || (kind == "geom" && child.attribute("mesh") && std::string(node.name()) == "body"))
      node.remove_child(child);
    else
      remove_meshes(child);
    child = next;
  }
}

void drop_attribute(pugi::xml_node node, const std::string& kind, const std::string& attribute) {
  if (node.name() == kind) node.remove_attribute(attribute.c_str());
  for (pugi::xml_node child : node.children()) drop_attribute(child, kind, attribute);
}

void remove_kind(pugi::xml_node node, const std::string& kind) {
  for (pugi::xml_node child = node.first_child(); child;) {
    pugi::xml_node next = child.next_sibling();
    if (child.name() == kind)
      node.remove_child(child);
    else
      remove_kind(child, kind);
    child = next;
  }
}

std::string between(const std::string& text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) return {};
  const std::size_t begin = at + from.size();
  return text.substr(begin, text.find(to, begin) - begin);
}

PeerModel load(pugi::xml_document& document, const PeerOptions& options) {
  PeerModel out;
  pugi::xml_node root = document.document_element();
  // Remove elements that do not affect the motion of rigid bodies and may refer to features that an older MuJoCo does not know.
  for (const char* kind :
       {"sensor", "actuator", "visual", "statistic", "size", "keyframe", "contact", "material", "texture", "skin", "hfield", "tendon"})
    remove_kind(root, kind);
  const auto drop_everywhere = [](auto&& self, pugi::xml_node node) -> void {
    node.remove_attribute("material");
    for (pugi::xml_node child : node.children()) self(self, child);
  };
  drop_everywhere(drop_everywhere, root);
  for (pugi::xml_node w : root.children("worldbody"))
    for (pugi::xml_node g = w.first_child(); g;) {
      pugi::xml_node next = g.next_sibling();
      if (g.attribute("hfield")) w.remove_child(g);
      g = next;
    }
  if (options.strip_meshes) remove_meshes(root);
  Lowering(root).expand();
  for (pugi::xml_node section : root.children("equality"))
    for (pugi::xml_node e = section.child("tendon"); e; e = section.child("tendon")) section.remove_child(e);
  const std::vector<SiteEquality> sites = lower_equalities(root);
  pugi::xml_node compiler = root.prepend_child("compiler");
  compiler.append_attribute("autolimits").set_value("true");

  const fs::path folder = fs::temp_directory_path() / ("ugoki-mjcf-peer-" + std::to_string(::getpid()));
  fs::create_directories(folder);
  if (options.stand_in)
    for (const pugi::xml_node asset : root.children("asset"))
      for (const pugi::xml_node mesh : asset.children("mesh"))
        if (mesh.attribute("file")) {
          std::string meshes;
          for (const pugi::xml_node c : root.children("compiler"))
            if (c.attribute("meshdir")) meshes = c.attribute("meshdir").value();
          const fs::path file = folder / meshes / mesh.attribute("file").value();
          fs::create_directories(file.parent_path());
          std::ofstream(file, std::ios::binary) << options.stand_in(mesh.attribute("file").value());
        }
  for (int tries = 0; tries < 100 && !out.model; ++tries) {
    document.save_file((folder / "model.xml").c_str());
    char why[1000] = "";
    out.model.reset(mj_loadXML((folder / "model.xml").c_str(), nullptr, why, sizeof why));
    out.why = why;
    const std::string attribute = between(why, "unrecognized attribute: '", "'"), kind = between(why, "Element '", "'");
    if (out.model || attribute.empty() || kind.empty()) break;
    drop_attribute(root, kind, attribute);
  }
  fs::remove_all(folder);
  if (!out.model) return out;
  mjModel* m = out.model.get();
  for (const SiteEquality& e : sites) set_equality_data(m, e);
  m->opt.disableflags = mjDSBL_CONTACT | mjDSBL_LIMIT | mjDSBL_FRICTIONLOSS | mjDSBL_PASSIVE | mjDSBL_ACTUATION | mjDSBL_EQUALITY;
  m->opt.jacobian = mjJAC_DENSE;
  out.data.reset(mj_makeData(m));
  return out;
}

}  // namespace

PeerModel open_with_mujoco(const std::string& path, const PeerOptions& options) {
  pugi::xml_document document;
  document.load_file(path.c_str());
  splice_includes(document.document_element(), fs::path(path).parent_path());
  return load(document, options);
}

PeerModel open_text_with_mujoco(const std::string& text, const PeerOptions& options) {
  pugi::xml_document document;
  document.load_string(text.c_str());
  return load(document, options);
}

}  // namespace ugoki::robot_formats
#endif
