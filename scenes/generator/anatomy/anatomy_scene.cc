#include "scenes/generator/anatomy/anatomy_scene.h"

#include <algorithm>
#include <cstdio>

namespace hpdm {
namespace {

/// Text with the number's shortest form to a micrometre.
std::string Number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6f", value);
  std::string number = text;
  while (number.back() == '0') number.pop_back();
  if (number.back() == '.') number.push_back('0');
  return number == "-0.0" ? "0.0" : number;
}

std::string Vector(const Vector3d& p) {
  return "[" + Number(p.x()) + ", " + Number(p.y()) + ", " + Number(p.z()) + "]";
}

const char* const kHead = R"(
# Frame: that of the liver's mesh. The patient lies on the back; x points to the patient's left, y to the
# head, z to the front (up). Units are SI. Values of attachments and tubes are guesses where nothing is
# published (scenes/README.md).

[scene]
name = "gallbladder before its removal"
gravity = [0.0, 0.0, -9.81]
background = "abdomen.png"

[[organ]]
name = "liver"
mesh = "liver_5000.obj"
texture = "liver_5000.png"

  [organ.lattice]
  cells = [6, 6, 6]
  local_functions = 27

  [organ.energy]
  type = "strain"
  strain = "small"

  [organ.material]
  young = 5500     # Pa
  poisson = 0.45

  # The bare area and the ligaments around it, and behind it the vena cava.
  [[organ.support]]
  box_fraction = { min = [0.0, 0.7, 0.0], max = [1.0, 1.0, 1.0] }
  fixed = true
  [[organ.support]]
  box_fraction = { min = [0.0, 0.4, 0.0], max = [1.0, 0.7, 0.35] }
  fixed = true

# A wall of 3 mm, filled with bile. It hangs on its bed, a leaf and its tubes, and comes free once they are cut.
[[organ]]
name = "gallbladder"
mesh = "gallbladder.obj"
texture = "gallbladder.png"
)";

const char* const kGallbladder = R"(
  [organ.lattice]
  cells = [8, 10, 8]
  margin = 0
  local_functions = 0

  [organ.energy]
  type = "strain"
  strain = "small"

  [organ.material]
  young = 30000   # Pa
  poisson = 0.45

  [[organ.lumen]]

  [organ.free]
  drag = 2.0      # 1/s

)";

const char* const kBed = R"(young = 20000       # Pa
thickness = 0.001   # m
strength = 20000    # Pa: the weight loads it with up to 10 kPa
toughness = 45      # J/m^2
reach = 0.006       # m

)";

const char* const kLeaf = R"(young = 1e5         # Pa
thickness = 0.0003  # m
strength = 8e4      # Pa
toughness = 1000    # J/m^2

)";

const char* const kTools =
    R"(# Four ports: right flank, below the right ribs, below the breastbone, and the navel for the laparoscope.
# The flank's grasper holds the fundus and is parked, as an assistant's. The left hand holds the pouch from
# below the right ribs, the right hand works below the breastbone.
[[instrument]]
name = "grasper"
type = "grasper"
trocar = [-0.09, -0.13, 0.10]
friction = 0.2

  [instrument.device]
  max_insertion = 0.24

  [[instrument.exchange]]
  name = "scissors"
  type = "scissors"

[[instrument]]
name = "hook"
type = "hook"
trocar = [0.07, -0.11, 0.135]
friction = 0.1

  [instrument.device]
  max_insertion = 0.24

  [[instrument.exchange]]
  name = "clip applier"
  type = "clip_applier"
  [[instrument.exchange]]
  name = "second grasper"
  type = "grasper"
  friction = 0.2

[[instrument]]
name = "left grasper"
type = "grasper"
trocar = [-0.02, -0.16, 0.125]
friction = 0.2

  [instrument.device]
  max_insertion = 0.24

[laparoscope]
trocar = [0.06, -0.235, 0.11]
position = [0.05, -0.165, 0.03]
target = [0.020, -0.060, -0.010]
angle_deg = 30
field_of_view_deg = 70
)";

std::string FilesOf(const std::string& organ) {
  const std::string stem = FileStem(organ);
  return "mesh = \"" + stem + ".obj\"\ntexture = \"" + stem + ".png\"\n";
}

std::string PathText(const std::string& key, const std::vector<Vector3d>& path) {
  std::string text = key + " = [\n";
  for (const Vector3d& p : path) text += "  " + Vector(p) + ",\n";
  return text + "]\n";
}

std::string TubeText(const Anatomy::Tube& tube) {
  std::string text = "[[duct]]\nname = \"" + tube.name + "\"\na = \"" + tube.a + "\"\nb = \"" +
                     tube.b + "\"\n" + PathText("path", tube.path);
  return text + "radius = " + Number(tube.radius) + "   # m\nwall = " + Number(tube.wall) +
         "   # m\nyoung = " + Number(tube.young) +
         "   # Pa, a guess\ncolour = " + Vector(tube.colour) + "\n\n";
}

}  // namespace

std::string FileStem(const std::string& organ) {
  std::string stem = organ;
  std::replace(stem.begin(), stem.end(), ' ', '_');
  return stem;
}

std::string AnatomySceneText(const Anatomy& anatomy, const std::string& command) {
  std::string text = "# A gallbladder before its removal. Made by: " + command + kHead;
  text += "\n  [organ.pose]\n  position = " + Vector(anatomy.gallbladder_position) +
          "\n  rotation_deg = [" + Number(Anatomy::kTilt) + ", 0, 0]\n";
  text += kGallbladder;
  for (const Anatomy::Organ& organ : anatomy.fixed) {
    text += "[[organ]]\nname = \"" + organ.name + "\"\n" + FilesOf(organ.name) +
            "model = \"rigid\"\n\n";
  }
  text +=
      "# The liver bed.\n[[attachment]]\na = \"gallbladder\"\nb = \"liver\"\nbox = { min = "
      "[-0.03, -0.115, 0.0], max = [0.05, -0.057, 0.06] }\n";
  text += kBed;
  text +=
      "# The front leaf of peritoneum over Calot's triangle.\n[[attachment]]\nname = \"peritoneal "
      "leaf\"\na = \"gallbladder\"\nb = \"liver\"\n";
  text += PathText("path_a", anatomy.leaf.on_gallbladder) +
          PathText("path_b", anatomy.leaf.on_liver) + kLeaf;
  for (const Anatomy::Tube& tube : anatomy.tubes) text += TubeText(tube);
  return text + kTools;
}

}  // namespace hpdm
