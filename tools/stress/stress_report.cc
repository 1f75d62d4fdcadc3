#include "tools/stress/stress_report.h"

#include <algorithm>
#include <cmath>

#include "tools/shared/json_rows.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

const char* FateName(StressFate fate) {
  if (fate == StressFate::kSurvived) return "survived";
  return fate == StressFate::kDegraded ? "degraded" : "failed";
}

Json OrNull(const std::optional<double>& value) { return value ? Json(*value) : Json(); }

std::string Value(const StressParameter& parameter, double value) {
  return Format(std::abs(value) < 1000 ? "%.3g" : "%.0f", value) +
         (parameter.unit.empty() ? "" : " " + parameter.unit);
}

std::string Percent(double error) {
  if (error > 0 && error < 5e-5) return "< 0.01 %";
  if (error < 0.0995) return Format("%.2g %%", 100 * error);
  return error < 9.995 ? Format("%.0f %%", 100 * error) : Format("%.0fx", error);
}

Json ToJson(const StressParameter& parameter) {
  return {{"name", parameter.name},
          {"unit", parameter.unit},
          {"easy", parameter.easy},
          {"asked", parameter.asked},
          {"utmost", parameter.utmost}};
}

Json ToJson(const StressResult& result) {
  return {{"model", Name(result.model)},
          {"fate", FateName(result.asked.fate)},
          {"error", OrNull(result.asked.error)},
          {"how", result.asked.how},
          {"holds_to", OrNull(result.holds_to)},
          {"fails_from", OrNull(result.fails_from)},
          {"fails_how", result.fails_how},
          {"harm", result.harm},
          {"trials", result.trials}};
}

// Returns "beyond 200 mm", "to 57 mm" or "fails from the start".
std::string Boundary(const StressParameter& parameter, const StressResult& result) {
  if (!result.fails_from) return "beyond " + Value(parameter, parameter.utmost);
  if (!result.holds_to) return "fails from the start";
  return "to " + Value(parameter, *result.holds_to);
}

std::string Verdict(const StressResult& result) {
  std::string text = FateName(result.asked.fate);
  if (result.asked.error) text += ", " + Percent(*result.asked.error);
  if (!result.asked.how.empty()) text += ", " + result.asked.how;
  return text;
}

const StressResult* Find(const StressRow& row, StressModel model) {
  for (const StressResult& result : row.results) {
    if (result.model == model) return &result;
  }
  return nullptr;
}

}  // namespace

Json ToJson(const StressRow& row) {
  const StressParameter& parameter = row.stress_case.parameter;
  Json json = {{"name", row.stress_case.name},   {"group", row.stress_case.group},
               {"title", row.stress_case.title}, {"truth", row.stress_case.truth},
               {"parameter", ToJson(parameter)}, {"results", Json::array()}};
  for (const StressResult& result : row.results) json["results"].push_back(ToJson(result));
  return json;
}

std::string StressCsv(const std::vector<StressRow>& rows) {
  std::string text;
  for (const StressRow& row : rows) {
    for (const StressResult& result : row.results) {
      Json line = {{"case", row.stress_case.name},
                   {"group", row.stress_case.group},
                   {"title", row.stress_case.title}};
      Json parameter = ToJson(row.stress_case.parameter);
      line["parameter"] = parameter["name"];
      parameter.erase("name");
      line.update(parameter);
      line.update(ToJson(result));
      if (text.empty()) text = CsvNames(line);
      text += CsvValues(line);
    }
  }
  return text;
}

std::string StressMarkdown(const std::vector<StressRow>& rows) {
  std::vector<StressModel> models;
  for (int m = 0; m < kStressModels; ++m) {
    const auto model = static_cast<StressModel>(m);
    if (std::any_of(rows.begin(), rows.end(),
                    [&](const StressRow& row) { return Find(row, model) != nullptr; })) {
      models.push_back(model);
    }
  }
  std::string text = "| case and its parameter |", rule = "|---|";
  for (const StressModel model : models) {
    text.append(" ").append(Title(model)).append(" |");
    rule += "---|";
  }
  text += "\n" + rule + "\n";
  for (const StressRow& row : rows) {
    const StressParameter& parameter = row.stress_case.parameter;
    text += "| " + row.stress_case.title + ": " + parameter.name + " " +
            Value(parameter, parameter.asked) + " |";
    for (const StressModel model : models) {
      const StressResult* result = Find(row, model);
      if (result == nullptr) {
        text += " - |";
        continue;
      }
      const std::string verdict = Verdict(*result);
      text += (result->asked.fate == StressFate::kFailed ? " **" + verdict + "**; "
                                                         : " " + verdict + "; ");
      text += Boundary(parameter, *result) + " |";
    }
    text += "\n";
  }
  return text;
}

std::string StressText(const StressRow& row) {
  const StressParameter& parameter = row.stress_case.parameter;
  std::string text = row.stress_case.name + ": " + row.stress_case.title + ", " + parameter.name +
                     " " + Value(parameter, parameter.asked) + "\n";
  for (const StressResult& result : row.results) {
    text += Format("  %-18s ", Title(result.model).c_str()) + Verdict(result) + "; " +
            Boundary(parameter, result);
    if (result.fails_from && !result.fails_how.empty() && result.asked.how != result.fails_how) {
      text += ", then " + result.fails_how;
    }
    if (!result.harm.empty()) text += "; HARM: " + result.harm;
    text += "\n";
  }
  return text;
}

std::vector<std::string> Harms(const std::vector<StressRow>& rows) {
  std::vector<std::string> harms;
  for (const StressRow& row : rows) {
    for (const StressResult& result : row.results) {
      if (result.harm.empty()) continue;
      harms.push_back(row.stress_case.name + ", " + Title(result.model) + ": " + result.harm);
    }
  }
  return harms;
}

}  // namespace hpdm
