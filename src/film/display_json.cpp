// The outputs of a plan as JSON inside shards: all that writing the pictures takes besides the film. What is read
// back comes from a file and is checked.
#include <algorithm>
#include <bit>
#include <cmath>
#include <nlohmann/json.hpp>

#include "film/display_output.h"
#include "film/json_text.h"

namespace kinora::film {
namespace {

using nlohmann::json;

json fromTexts(const std::vector<std::string>& list) {
  json j = json::array();
  for (const std::string& s : list) j.push_back(jsonOfText(s));
  return j;
}
std::vector<std::string> toTexts(const json& j) {
  std::vector<std::string> list;
  for (const json& s : j) list.push_back(textOfJson(s));
  return list;
}
// JSON has no infinities: floats that are no finite number are kept as their bits.
json fromFloats(const std::vector<float>& list) {
  json j = json::array();
  for (const float f : list)
    if (std::isfinite(f))
      j.push_back(f);
    else
      j.push_back({{"bits", std::bit_cast<uint32_t>(f)}});
  return j;
}
std::vector<float> toFloats(const json& j) {
  std::vector<float> list;
  for (const json& f : j)
    list.push_back(f.is_object() ? std::bit_cast<float>(f.at("bits").get<uint32_t>()) : f.get<float>());
  return list;
}

json fromParams(const scene::ParameterList& list) {
  json params = json::array();
  for (const scene::Parameter& p : list)
    params.push_back({{"name", jsonOfText(p.name)},
                      {"storage", int(p.storage)},
                      {"type", int(p.type)},
                      {"isReference", p.isReference},
                      {"isArray", p.isArray},
                      {"length", p.arrayLength},
                      {"floats", fromFloats(p.floats)},
                      {"ints", p.ints},
                      {"strings", fromTexts(p.strings)}});
  return params;
}
scene::ParameterList toParams(const json& j) {
  scene::ParameterList list;
  for (const json& p : j) {
    scene::Parameter parameter;
    parameter.name = textOfJson(p.at("name"));
    const int type = p.at("type").get<int>(), storage = p.at("storage").get<int>();
    if (type < 0 || type > int(scene::ValueType::Struct) || storage < 0 ||
        storage > int(scene::StorageClass::FaceVertex))
      throw std::runtime_error("a parameter has no known type");
    parameter.type = scene::ValueType(type);
    parameter.storage = scene::StorageClass(storage);
    parameter.isReference = p.at("isReference").get<bool>();
    parameter.isArray = p.at("isArray").get<bool>();
    parameter.arrayLength = p.at("length").get<int>();
    parameter.floats = toFloats(p.at("floats"));
    parameter.ints = p.at("ints").get<std::vector<int>>();
    parameter.strings = toTexts(p.at("strings"));
    list.set(std::move(parameter));
  }
  return list;
}

json fromOutput(const Output& o, const ChannelLayout& layout) {
  json channels = json::array();
  for (const OutputChannel& c : o.channels)
    channels.push_back({{"channel", jsonOfText(layout[c.channel].name)},
                        {"names", fromTexts(c.names)},
                        {"isColor", c.isColor},
                        {"exposure", fromFloats({c.values.gain, c.values.gamma})},
                        {"quantize", fromFloats({c.values.zero, c.values.one, c.values.least, c.values.most})},
                        {"dither", fromFloats({c.values.dither})}});
  return {{"file", jsonOfText(o.file)},
          {"driver", jsonOfText(o.driver)},
          {"isBeauty", o.isBeauty},
          {"channels", channels},
          {"params", fromParams(o.params)}};
}
Output toOutput(const json& o, const ChannelLayout& layout) {
  Output output;
  output.file = textOfJson(o.at("file"));
  output.driver = textOfJson(o.at("driver"));
  output.isBeauty = o.at("isBeauty").get<bool>();
  for (const json& c : o.at("channels")) {
    OutputChannel channel;
    channel.channel = layout.find(textOfJson(c.at("channel")));
    channel.names = toTexts(c.at("names"));
    channel.isColor = c.at("isColor").get<bool>();
    const std::vector<float> exposure = toFloats(c.at("exposure")), quantize = toFloats(c.at("quantize")),
                             dither = toFloats(c.at("dither"));
    if (channel.channel < 0 || int(channel.names.size()) != layout[channel.channel].width)
      throw std::runtime_error("a picture names a channel that the shard lacks");
    if (exposure.size() != 2 || quantize.size() != 4 || dither.size() != 1)
      throw std::runtime_error("a picture's exposure is no pair of numbers");
    channel.values = {exposure[0], exposure[1], quantize[0], quantize[1], quantize[2], quantize[3], dither[0]};
    output.channels.push_back(std::move(channel));
  }
  output.params = toParams(o.at("params"));
  if (output.channels.empty()) throw std::runtime_error("a picture has no channels");
  return output;
}

json fromNode(const scene::Node& n) {
  return {{"kind", jsonOfText(n.kind)},
          {"plugin", jsonOfText(n.plugin)},
          {"handle", jsonOfText(n.handle)},
          {"params", fromParams(n.params)}};
}
scene::NodePtr toNode(const json& j) {
  auto n = std::make_shared<scene::Node>();
  n->kind = textOfJson(j.at("kind"));
  n->plugin = textOfJson(j.at("plugin"));
  n->handle = textOfJson(j.at("handle"));
  n->params = toParams(j.at("params"));
  return n;
}

json fromMatrix(const image::Matrix44& m) { return fromFloats({m.begin(), m.end()}); }
image::Matrix44 toMatrix(const json& j) {
  const std::vector<float> list = toFloats(j);
  image::Matrix44 m;
  if (list.size() != m.size()) throw std::runtime_error("a matrix has not 16 numbers");
  std::copy(list.begin(), list.end(), m.begin());
  return m;
}

}  // namespace

std::string outputsToJson(const DisplayPlan& plan, const FrameMetadata& frame) {
  json outputs = json::array(), filters = json::array();
  for (const Output& o : plan.outputs) outputs.push_back(fromOutput(o, plan.layout));
  for (const scene::NodePtr& n : plan.displayFilters) filters.push_back(fromNode(*n));
  json j{{"outputs", outputs},
         {"displayFilters", filters},
         {"texturePath", fromTexts(plan.texturePath)},
         {"pixelAspect", plan.pixelAspect},
         {"worldToCamera", fromMatrix(frame.worldToCamera)},
         {"screenWindow", fromFloats({frame.screenWindow.begin(), frame.screenWindow.end()})}};
  if (plan.unwritten) j["unwritten"] = fromOutput(*plan.unwritten, plan.layout);
  if (frame.worldToNdc) j["worldToNDC"] = fromMatrix(*frame.worldToNdc);
  return j.dump();
}

image::Status outputsFromJson(const std::string& text, const ChannelLayout& layout, DisplayPlan& out,
                              FrameMetadata& frame) {
  out = {};
  out.layout = layout;
  try {
    const json j = json::parse(text);
    out.pixelAspect = j.at("pixelAspect").get<float>();
    frame.worldToCamera = toMatrix(j.at("worldToCamera"));
    if (j.contains("worldToNDC")) frame.worldToNdc = toMatrix(j.at("worldToNDC"));
    const std::vector<float> window = toFloats(j.at("screenWindow"));
    if (window.size() != frame.screenWindow.size()) throw std::runtime_error("the screen window has not 3 numbers");
    std::copy(window.begin(), window.end(), frame.screenWindow.begin());
    for (const json& o : j.at("outputs")) out.outputs.push_back(toOutput(o, layout));
    if (j.contains("unwritten")) out.unwritten = toOutput(j.at("unwritten"), layout);
    for (const json& n : j.at("displayFilters")) out.displayFilters.push_back(toNode(n));
    out.texturePath = toTexts(j.at("texturePath"));
  } catch (const std::exception& e) {
    out = {};
    return image::Status::fail("FILM-SHARD-OUTPUTS",
                               std::string("the shard's description of its pictures: ") + e.what());
  }
  return {};
}

}  // namespace kinora::film
