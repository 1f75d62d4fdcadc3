#include <algorithm>
#include <map>
#include <set>

#include "scenes/loader/scene_keys.h"
#include "tests/support/scene_fixture.h"

/// Checks that scenes/README.md describes the loader.

namespace hpdm {
namespace {

/// Writes every value of a scene except its path and text, to compare two scenes.
std::string Dump(const Scene& scene) {
  std::ostringstream out;
  out.precision(17);
  out << scene.name << ' ' << scene.background << '\n';
  const TimingOptions& t = scene.timing;
  out << t.haptic_hz << ' ' << t.deformation_hz << ' ' << t.render_hz << ' ' << t.patch_delay_ticks
      << '\n';
  for (const OrganOptions& o : scene.organs) {
    out << o.name << ' ' << o.mesh << ' ' << o.unit_m << '\n' << o.X_WO.matrix() << '\n';
    out << static_cast<int>(o.model) << ' ' << o.texture << '\n';
    out << static_cast<int>(o.lattice.basis) << ' ' << o.lattice.margin << ' ' << o.lattice.split;
    for (const int d : o.lattice.degree) out << ' ' << d;
    for (const int c : o.lattice.cells) out << ' ' << c;
    out << ' ' << LocalFunctionsOf(o) << ' ' << o.lattice.local.refinement;
    out << '\n' << static_cast<int>(o.energy.type) << ' ' << static_cast<int>(o.energy.strain);
    out << ' ' << static_cast<int>(o.energy.law) << ' ' << static_cast<int>(o.energy.solver);
    out << ' ' << static_cast<int>(o.energy.domain) << ' ' << o.energy.alpha << ' ' << o.energy.beta
        << '\n';
    out << o.material.young << ' ' << o.material.poisson << ' ' << o.material.density << ' '
        << o.material.prony.count << '\n';
    for (const PronySeries::Term& term : o.material.prony.terms) {
      out << term.share << ' ' << term.time << '\n';
    }
    for (const LumenOptions& lumen : o.lumens) {
      out << lumen.region.has_value() << lumen.filled << ' ' << lumen.bulk_modulus << ' '
          << lumen.pressure << ' ' << lumen.leak_resistance << ' '
          << lumen.perforated_at.value_or(-1) << '\n';
    }
    for (const LayerOptions& layer : o.layers) {
      out << layer.region.has_value() << ' ' << layer.stiffness << ' ' << layer.poisson << ' '
          << layer.strength.value_or(-1) << '\n';
    }
    out << o.regions.size() << " regions " << o.supports.size() << " supports\n"
        << o.wall_stiffness.value_or(-1) << '\n';
  }
  for (const InstrumentOptions& i : scene.instruments) {
    for (int e = 0; e < i.HeldCount(); ++e) {
      const InstrumentDescription& held = i.Held(e);
      out << held.name << ' ' << static_cast<int>(held.type) << ' ' << held.mesh << ' '
          << held.jaws.meshes.size() << ' ' << held.insulated_from.value_or(-1) << ' '
          << held.geometry.tip_radius << ' ' << held.geometry.shaft_radius << ' '
          << held.geometry.friction << '\n';
    }
    out << i.trocar_friction << ' ' << i.trocar_torque << ' ';
    out << i.p_trocar_W.transpose() << ' ' << static_cast<int>(i.reaction) << ' ' << i.k1 << ' '
        << i.k2 << '\n';
    const DeviceProfile& d = i.device;
    for (const double x : {d.mass, d.rotational_inertia, d.damping, d.rotational_damping,
                           d.friction, d.rotational_friction, d.encoder_step, d.angle_encoder_step,
                           d.jaw_encoder_step, d.max_force, d.max_torque, d.max_force_rate,
                           d.max_angle, d.min_insertion, d.max_insertion, d.delay}) {
      out << x << ' ';
    }
    out << d.passivity_control;
    const HandOptions& h = i.hand;
    out << '\n' << static_cast<int>(h.script) << ' ' << h.seed << ' ' << h.organ << ' ';
    if (h.target) out << h.target->transpose();
    out << ' ' << h.depth << ' ' << h.spread << ' ' << h.speed << ' ' << h.stiffness << ' '
        << h.damping << ' ' << h.tremor << '\n';
    out << i.trace.file << ' ' << i.trace.scale << '\n' << i.trace.R_WF << '\n';
    if (i.trace.position) out << i.trace.position->transpose();
    out << ' ' << i.trace.speed << '\n';
  }
  const LaparoscopeOptions& l = scene.laparoscope;
  out << l.p_scope_W.transpose() << ' ' << l.p_target_W.transpose() << ' ' << l.angle << ' '
      << l.field_of_view << ' ' << l.distortion << ' ';
  if (l.p_trocar_W) out << l.p_trocar_W->transpose();
  out << '\n';
  return out.str();
}

/// Header ("organ.lattice") and key -> the row's cells.
std::map<std::string, std::map<std::string, std::vector<std::string>>> ReadmeTables() {
  std::map<std::string, std::map<std::string, std::vector<std::string>>> tables;
  std::ifstream file(std::filesystem::path(HPDM_SOURCE_DIR) / "scenes/README.md");
  std::string header, line;
  while (std::getline(file, line)) {
    if (line.starts_with("#")) {
      header.clear();
      for (const char c : line) {
        if (c != '#' && c != ' ' && c != '[' && c != ']') header += c;
      }
      if (header == "Tables") header.clear();
    } else if (line.starts_with("| `")) {
      std::vector<std::string> cells;
      std::istringstream row(line.substr(1));
      for (std::string cell; std::getline(row, cell, '|');) {
        const std::size_t first = cell.find_first_not_of(' ');
        const std::size_t last = cell.find_last_not_of(' ');
        cells.push_back(first == std::string::npos ? "" : cell.substr(first, last - first + 1));
      }
      tables[header][cells[0].substr(1, cells[0].size() - 2)] = cells;
    }
  }
  return tables;
}

TEST_F(SceneTest, ReadmeDescribesExactlyTheKnownKeys) {
  const auto readme = ReadmeTables();
  EXPECT_EQ(readme.size(), std::size(kSceneTables));
  for (const SceneTable& table : kSceneTables) {
    std::set<std::string> described;
    const std::set<std::string> known(table.keys.begin(), table.keys.end());
    const auto found = readme.find(std::string(table.path));
    ASSERT_NE(found, readme.end()) << "no section [" << table.path << "]";
    for (const auto& [key, cells] : found->second) described.insert(key);
    EXPECT_EQ(described, known) << "section [" << table.path << "]";
  }
}

TEST_F(SceneTest, ReadmeDefaultsAreTheLoadersDefaults) {
  auto readme = ReadmeTables();
  readme.erase("");
  // Returns the defaults behind `prefix` in a table as lines of a scene.
  const auto defaults_behind = [&](const std::string& prefix, const std::string& table) {
    std::string lines;
    for (const auto& [key, cells] : readme.at(table)) {
      if (!cells[3].starts_with(prefix + "`")) continue;
      const std::size_t at = prefix.size() + 1;
      lines += key + " = " + cells[3].substr(at, cells[3].find('`', at) - at) + "\n";
    }
    return lines;
  };
  const std::string metric = kOrgan + "[organ.energy]\ntype = \"metric\"\n";
  const std::string metric_defaults = defaults_behind("type metric: ", "organ.energy");
  EXPECT_EQ(std::ranges::count(metric_defaults, '\n'), 3) << "domain, alpha and beta";
  EXPECT_EQ(Dump(Load(metric + metric_defaults)), Dump(Load(metric)));
  // Returns all defaults of a table and marks it as checked.
  const auto defaults = [&](const std::string& table) {
    const std::string lines = defaults_behind("", table);
    readme.erase(table);
    return lines;
  };
  std::string written = "[scene]\n" + defaults("scene") + "[timing]\n" + defaults("timing");
  written += kOrgan + defaults("organ");
  for (const char* part : {"pose", "lattice", "energy", "material"}) {
    written += std::string("[organ.") + part + "]\n" + defaults(std::string("organ.") + part);
  }
  const std::string support =
      kOrgan + "[[organ.support]]\nsphere = {centre=[0,0,0], radius=1}\nstiffness = 1e6\n";
  EXPECT_EQ(Dump(Load(support + defaults("organ.support"))), Dump(Load(support)));
  const std::string lumen = kOrgan + "[[organ.lumen]]\n";
  EXPECT_EQ(Dump(Load(lumen + defaults("organ.lumen"))), Dump(Load(lumen)));
  const std::string layer = kOrgan + "[[organ.layer]]\nstiffness = 20\n";
  EXPECT_EQ(Dump(Load(layer + defaults("organ.layer"))), Dump(Load(layer)));
  const std::string step = "[[exercise.step]]\nname = 'a'\nforce = 1\n";
  const std::string error = "[[exercise.error]]\nkind = 'force'\n";
  const ExerciseOptions plain = *Load(kOrgan + "[exercise]\n" + step + error).exercise;
  const ExerciseOptions given =
      *Load(kOrgan + "[exercise]\n" + defaults("exercise") + step + defaults("exercise.step") +
            error + defaults("exercise.error"))
           .exercise;
  EXPECT_EQ(given.time_limit, plain.time_limit);
  EXPECT_EQ(given.steps[0].time, plain.steps[0].time);
  EXPECT_EQ(given.errors[0].points, plain.errors[0].points);
  const std::string contact =
      "[[organ]]\nname='second'\nmesh='m.obj'\n[[contact]]\na='liver'\nb='second'\n";
  written += contact + defaults("contact");
  written += kInstrument + defaults("instrument");
  written += "[instrument.device]\n" + defaults("instrument.device");
  written += "[instrument.hand]\n" + defaults("instrument.hand");
  written += "[instrument.trace]\n" + defaults("instrument.trace");
  const std::string exchange = "[[instrument.exchange]]\nname='other'\n";
  written += exchange + defaults("instrument.exchange");
  written += "[laparoscope]\n" + defaults("laparoscope");
  EXPECT_EQ(Dump(Load(written)), Dump(Load(kOrgan + contact + kInstrument + exchange))) << written;
  while (!readme.empty()) {
    const std::string table = readme.begin()->first;
    EXPECT_EQ(defaults(table), "") << "the defaults of [" << table << "] were not checked";
  }
}

TEST_F(SceneTest, ReadmeQuotesRealMessages) {
  const std::string readme = ReadFile(std::filesystem::path(HPDM_SOURCE_DIR) / "scenes/README.md");
  const std::string head = "[[organ]]\nname = 'liver'\nmesh = 'm.obj'\n\n\n\n\n";
  const auto message = [&](const std::string& text) {
    folder_.Write("liver.toml", text);
    return Shorten(ErrorOf([&] { LoadScene(folder_.path() / "liver.toml"); }));
  };
  EXPECT_TRUE(Contains(readme, "    " + message(head + "[organ.lattice]\n  marign = 0.01\n")));
  EXPECT_TRUE(
      Contains(readme, "    " + message(head + "\n\n\n\n\n[organ.material]\npoisson = 0.5\n")));
}

}  // namespace
}  // namespace hpdm
