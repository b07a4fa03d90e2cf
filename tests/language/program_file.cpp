#include "language/program_file.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "language/front/compile.h"

namespace kinora::oracle {

namespace {

std::string trimmed(std::string s) {
  const size_t a = s.find_first_not_of(" \t"), b = s.find_last_not_of(" \t\r");
  return a == std::string::npos ? "" : s.substr(a, b - a + 1);
}
std::string word(std::string& rest) {
  const size_t end = rest.find(' ');
  std::string w = rest.substr(0, end);
  rest = end == std::string::npos ? "" : trimmed(rest.substr(end));
  return w;
}
// "...\n..." with the escapes of C that programs use
std::string unquoted(const std::string& s, std::string& wrong) {
  if (s.size() < 2 || s.front() != '"' || s.back() != '"') {
    wrong = "not in quotes: " + s;
    return {};
  }
  std::string out;
  for (size_t i = 1; i + 1 < s.size(); ++i) {
    if (s[i] != '\\') {
      out += s[i];
      continue;
    }
    const char c = s[++i];
    out += c == 'n' ? '\n' : c == 't' ? '\t' : c;
  }
  return out;
}
double toleranceIn(std::string& rest, double otherwise) {
  const size_t at = rest.rfind(" ~");
  if (at == std::string::npos) return otherwise;
  const double t = std::stod(rest.substr(at + 2));
  rest = trimmed(rest.substr(0, at));
  return t;
}

void directive(ProgramFile& p, const std::string& what, std::string rest, int line) {
  if (what == "expect") {
    Expected e;
    e.output = word(rest);
    e.line = line;
    e.isText = rest.starts_with('"');
    if (e.isText)
      e.text = unquoted(rest, p.wrong);
    else
      e.tolerance = toleranceIn(rest, -1);
    e.formula = rest;
    p.expected.push_back(std::move(e));
  } else if (what == "prints" || what == "tells") {
    Said s;
    s.isOnce = what == "tells";
    const size_t quote = rest.find('"');
    if (rest.starts_with("when ")) s.when = trimmed(rest.substr(5, quote - 5));
    s.text = unquoted(quote == std::string::npos ? rest : rest.substr(quote), p.wrong);
    p.said.push_back(std::move(s));
  } else if (what == "difference") {
    Difference d;
    d.tolerance = toleranceIn(rest, d.tolerance);
    d.of = word(rest);
    d.x = word(rest);
    d.y = word(rest);
    p.differences.push_back(std::move(d));
  } else if (what == "roads") {
    p.isFolded = p.isUniform = p.isVarying = false;
    while (!rest.empty()) {
      const std::string w = word(rest);
      (w == "folded" ? p.isFolded : w == "uniform" ? p.isUniform : p.isVarying) = true;
    }
  } else if (what == "alike") {
    p.isAlike = false;
  }
}

ProgramFile readProgram(const std::string& path, const std::string& name) {
  ProgramFile p;
  p.name = name;
  std::ifstream in(path);
  std::vector<std::pair<std::string, std::string>> layers = {{"layer", ""}};
  int line = 0;
  for (std::string text; std::getline(in, text);) {
    ++line;
    p.source += text + "\n";
    const std::string t = trimmed(text);
    if (t.starts_with("// ")) {
      std::string rest = trimmed(t.substr(3));
      const std::string what = word(rest);
      if (what == "layer") {
        if (layers.size() == 1 && layers[0].second.find("shader") == std::string::npos) layers.clear();
        layers.push_back({word(rest), std::string(size_t(line - 1), '\n')});
      } else if (what == "connect") {
        const std::string from = word(rest), to = word(rest);
        const size_t a = from.find('.'), b = to.find('.');
        p.group.connections.push_back({from.substr(0, a), from.substr(a + 1), to.substr(0, b), to.substr(b + 1)});
      } else {
        directive(p, what, rest, line);
      }
    }
    layers.back().second += text + "\n";
  }
  for (const auto& [layer, source] : layers) {
    language::CompileOptions options;
    options.uses = &p.uses;
    language::CompileResult r = language::compile(source, name, options);
    for (const language::CompileMessage& m : r.messages)
      if (m.severity == Severity::Error) p.wrong += m.str() + "\n";
    if (!r.ok()) return p;
    p.shaders.push_back(std::make_shared<const language::Shader>(std::move(*r.shader)));
    p.group.layers.push_back({p.shaders.back(), layer, {}});
  }
  for (const Expected& e : p.expected)
    if (std::find(p.group.outputs.begin(), p.group.outputs.end(), e.output) == p.group.outputs.end())
      p.group.outputs.push_back(e.output);
  for (const Difference& d : p.differences)
    for (const std::string& o : {d.of, d.x, d.y})
      if (std::find(p.group.outputs.begin(), p.group.outputs.end(), o) == p.group.outputs.end())
        p.group.outputs.push_back(o);
  if (p.expected.empty() && p.said.empty() && p.differences.empty()) p.wrong += "nothing is expected of it";
  return p;
}

}  // namespace

std::vector<ProgramFile> readPrograms() {
  const std::filesystem::path root = std::string(KINORA_SOURCE_DIR) + "/tests/language/programs";
  std::vector<std::string> names;
  for (const auto& e : std::filesystem::recursive_directory_iterator(root))
    if (e.path().extension() == ".osl") names.push_back(std::filesystem::relative(e.path(), root).string());
  std::sort(names.begin(), names.end());
  std::vector<ProgramFile> all;
  for (const std::string& n : names) all.push_back(readProgram((root / n).string(), n));
  return all;
}

}  // namespace kinora::oracle
