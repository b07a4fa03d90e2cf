#include "shade/standard_shaders.h"

#include <algorithm>

#include "base/text.h"
#include "language/seexpr/translate.h"
#include "shade/connected_bumps.h"

namespace kinora::shade {

namespace {

constexpr const char* kAttribute = R"(
shader PxrAttribute(string varname = "", string type = "float", int defaultInt = 0, float defaultFloat = 0,
                    vector defaultFloat3 = 0, color defaultColor = 0, int verbosity = 0,
                    output color resultRGB = 0, output float resultR = 0, output float resultG = 0,
                    output float resultB = 0, output float resultF = 0, output int resultI = 0) {
  color c = defaultFloat, three = 0;
  int whole = 0;
  float number = 0;
  float pair[2] = {0, 0};
  vector triple = 0;
  if (type == "color") {
    c = defaultColor;
    if (!getattribute(varname, c) && getattribute(varname, number)) c = number;
  } else if (type == "int") {
    if (!getattribute(varname, whole)) whole = getattribute(varname, number) ? (int)trunc(number) : defaultInt;
    c = whole;
  } else if (type == "float") {
    if (getattribute(varname, number)) c = number;
    else if (getattribute(varname, whole)) c = whole;
    else if (getattribute(varname, pair)) c = pair[0];
    else if (getattribute(varname, three)) c = three[0];
  } else if (type == "float2") {
    c = (color)defaultFloat3;
    if (getattribute(varname, pair)) c = color(pair[0], pair[1], 0);
  } else {
    c = (color)defaultFloat3;
    if (getattribute(varname, triple)) c = (color)triple;
  }
  resultRGB = c;
  resultR = c[0];
  resultG = c[1];
  resultB = c[2];
  resultF = c[0];
  resultI = type == "int" ? whole : (int)c[0];
}
)";

// PxrBump with heights of a shader, whose derivatives are its slopes.
constexpr const char* kBump = R"(
shader PxrBump(float scale = 1, int disable = 0, float inputBump = 0, normal inputN = 0, int reverse = 0,
               float surfaceNormalMix = 0, output normal resultN = 0, output vector resultNG = 0) {
  normal own = inputN == normal(0) ? N : normalize(inputN);
  resultN = own;
  float size = area(P);
  if (!disable && size > 0) {
    float height = (reverse ? -scale : scale) * inputBump;
    vector slope = (calculatenormal(P + N * height) - calculatenormal(P)) / size;
    if (inputN != normal(0)) slope -= own * dot(own, slope);
    resultN = normalize(mix(normalize(own + slope), own, surfaceNormalMix));
  }
  resultNG = N - resultN / max(dot(resultN, N), 0.01);
}
)";

// PxrMatteID: the object's attribute times a pattern where one is connected or not black, either alone where there is no
// other. The outputs are those that tees.h finds.
std::string matteShader() {
  std::string parameters, body;
  for (const char n : std::string("01234567")) {
    const std::string texture = std::string("matteTexture") + n, name = std::string("MatteID") + n;
    parameters += "color " + texture + " = 0, ";
    body += name + " = matte(\"user:" + name + "\", " + texture + ", isconnected(" + texture + "));\n";
  }
  std::string outputs;
  for (const char n : std::string("01234567")) outputs += std::string(", output color MatteID") + n + " = 0";
  return R"(
color matte(string attribute, color pattern, int isConnected) {
  color own = 0;
  if (!getattribute(attribute, own)) return pattern;
  return isConnected || pattern != color(0) ? own * pattern : own;
}
shader PxrMatteID(int inputAOV = 0, int enable = 1, )" +
         parameters + "output int resultAOV = 0" + outputs + ") {\nif (enable) {\n" + body + "}\n}\n";
}

StandardShader ofExpression(const scene::Node& node, ShaderLibrary& library) {
  StandardShader out;
  out.node = node;
  out.node.params = {};
  std::string expression;
  std::vector<language::seexpr::Input> inputs;
  for (const char* name : {"colorInput1", "colorInput2", "colorInput3", "colorInput4"})
    inputs.push_back({name, true});
  for (const char* name : {"floatInput1", "floatInput2", "floatInput3", "floatInput4"})
    inputs.push_back({name, false});
  for (const scene::Parameter& p : node.params) {
    if (sameName(p.name, "expression") && !p.isReference) {
      // lines may be given as several strings
      for (const std::string& s : p.strings) expression += (expression.empty() ? "" : "\n") + s;
      continue;
    }
    if (p.name.starts_with("__")) continue;
    const bool isTriple = scene::isFloatBased(p.type) && scene::componentsOf(p.type) == 3;
    const auto known = std::find_if(inputs.begin(), inputs.end(), [&](const auto& i) { return i.name == p.name; });
    if (known == inputs.end())
      inputs.push_back({p.name, isTriple});
    else
      known->isTriple = isTriple;
  }
  const language::seexpr::Translation t = language::seexpr::translate(expression, inputs, "PxrSeExpr");
  if (!t.problem.empty()) {
    out.shader = library.refused(expression, t.problem, node.pos);
    return out;
  }
  out.shader = library.fromSource(t.source, "PxrSeExpr");
  for (const scene::Parameter& p : node.params) {
    if (std::find(t.inputs.begin(), t.inputs.end(), p.name) == t.inputs.end()) continue;
    scene::Parameter input = p;
    input.name = language::seexpr::parameterOf(p.name);
    out.node.params.set(std::move(input));
  }
  return out;
}

}  // namespace

std::optional<StandardShader> standardShader(const scene::Node& node, ShaderLibrary& library) {
  if (sameName(node.plugin, "PxrSeExpr")) return ofExpression(node, library);
  if (sameName(node.plugin, "PxrAttribute"))
    return StandardShader{library.fromSource(kAttribute, "PxrAttribute"), node};
  if (sameName(node.plugin, "PxrMatteID"))
    return StandardShader{library.fromSource(matteShader(), "PxrMatteID"), node};
  if (node.params.find(kBumpOfShader)) return StandardShader{library.fromSource(kBump, "PxrBump"), node};
  return std::nullopt;
}

}  // namespace kinora::shade
