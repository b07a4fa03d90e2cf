#include "app/plugin_manual.h"

#include <fmt/format.h>

#include <algorithm>

#include "plugin/refused.h"
#include "plugin/registry.h"
#include "plugin/types.h"

namespace kinora::app {

namespace {

const char* nameOf(Type type) {
  static const char* const kNames[] = {"float",  "int",    "string", "color", "point",
                                       "vector", "normal", "matrix", "struct"};
  return size_t(type) < std::size(kNames) ? kNames[size_t(type)] : "unknown";
}

std::string typeOf(const Param& p) { return std::string(nameOf(p.type)) + (p.flags & kParamArray ? "[]" : ""); }

std::string defaultOf(const Param& p) {
  if (p.flags & kParamArray) {
    std::string text;
    for (uint32_t i = 0; i < p.listCount; ++i) text += fmt::format("{}{}", i ? " " : "", p.list[i]);
    return "[" + text + "]";
  }
  if (p.type == Type::String) return fmt::format("\"{}\"", p.text ? p.text : "");
  if (p.type == Type::Struct || p.type == Type::Matrix) return "-";
  const float* v = p.value;
  if (componentsOf(p.type) == 1) return fmt::format("{}", v[0]);
  if (v[0] == v[1] && v[1] == v[2]) return fmt::format("{}", v[0]);
  return fmt::format("{} {} {}", v[0], v[1], v[2]);
}

// Ranges mean something for numbers only.
std::string rangeOf(const Param& p) {
  if (p.choices && *p.choices) return p.choices;
  if (p.type == Type::String || p.type == Type::Struct || p.type == Type::Matrix ||
      p.flags & (kParamFile | kParamOutput))
    return "";
  return fmt::format("{} .. {}", p.low, p.high);
}

std::string notesOf(const Param& p) {
  std::string notes;
  if (p.flags & kParamFile) notes += " A texture file.";
  if (p.flags & kParamNotConnectable && !(p.flags & kParamFile)) notes += " Not connectable.";
  return notes;
}

std::vector<const Descriptor*> sorted(std::vector<const Descriptor*> plugins) {
  std::sort(plugins.begin(), plugins.end(), [](const Descriptor* a, const Descriptor* b) {
    return a->kind != b->kind ? a->kind < b->kind : std::string_view(a->name) < std::string_view(b->name);
  });
  return plugins;
}

// A bar would end a table's cell.
std::string cell(std::string text) {
  for (size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) text.insert(at, "\\");
  return text;
}

template <class F>
void eachParam(const Descriptor& d, bool outputs, F&& f) {
  for (uint32_t i = 0; i < d.paramCount; ++i)
    if (bool(d.params[i].flags & kParamOutput) == outputs) f(d.params[i]);
}

}  // namespace

std::string pluginList(const std::vector<const Descriptor*>& plugins) {
  std::string out;
  size_t width = 22;
  for (const Descriptor* d : plugins) width = std::max(width, std::string_view(d->name).size());
  for (const Descriptor* d : sorted(plugins))
    out += fmt::format("{:<14}{:<{}}  {}\n", kinora::nameOf(d->kind), d->name, width, d->doc ? d->doc : "");
  return out;
}

std::string pluginText(const Descriptor& d) {
  std::string out = fmt::format("{} ({})\n{}\n", d.name, kinora::nameOf(d.kind), d.doc ? d.doc : "");
  size_t width = 0;
  for (uint32_t i = 0; i < d.paramCount; ++i) width = std::max(width, std::string_view(d.params[i].name).size());
  for (const bool outputs : {false, true}) {
    bool isFirst = true;
    eachParam(d, outputs, [&](const Param& p) {
      if (isFirst) out += outputs ? "\nOutputs\n" : "\nParameters\n";
      isFirst = false;
      out += fmt::format("  {:<{}}  {:<8}", p.name, width, typeOf(p));
      if (!outputs) {
        out += fmt::format(" = {}", defaultOf(p));
        if (const std::string range = rangeOf(p); !range.empty()) out += "  (" + range + ")";
      }
      out += "\n";
      const std::string help = std::string(p.doc ? p.doc : "") + (outputs ? "" : notesOf(p));
      if (!help.empty()) out += fmt::format("  {:<{}}  {}\n", "", width, help);
    });
  }
  return out;
}

std::string pluginsMarkdown(const std::vector<const Descriptor*>& plugins) {
  std::string out =
      "# Plug-ins\n\nMade by `tools/make_plugin_pages` from the plug-ins' own declarations; a test compares the two. "
      "Each has "
      "a page\nwith its parameters. Names match without case.\n";
  const char* kind = "";
  for (const Descriptor* d : sorted(plugins)) {
    if (std::string_view(kind) != kinora::nameOf(d->kind)) {
      kind = kinora::nameOf(d->kind);
      out += fmt::format("\n## Kind: {}\n\n| | | |\n|---|---|---|\n", kind);
    }
    out += fmt::format("| {} | [{}](plugins/{}.md) | {} |\n",
                       hasPicture(*d) ? fmt::format("![](plugins/images/{}.jpg)", d->name) : "", d->name, d->name,
                       cell(d->doc ? d->doc : ""));
  }
  out +=
      "\n## Not in this version\n\nNames that files have and what is told of them (`PLUGIN-MISSING`).\n\n"
      "| kind | name | why | instead |\n|---|---|---|---|\n";
  for (const RefusedPlugin& r : refusedPlugins())
    out += fmt::format("| {} | {} | {} | {} |\n", kinora::nameOf(r.kind), r.name, cell(r.why), cell(r.instead));
  return out;
}

std::string pluginPage(const Descriptor& d) {
  std::string out = fmt::format("# {}\n\nKind: {}. {}\n", d.name, kinora::nameOf(d.kind), d.doc ? d.doc : "");
  if (hasPicture(d)) out += fmt::format("\n![{}](images/{}.jpg)\n", d.name, d.name);
  for (const bool outputs : {false, true}) {
    bool isFirst = true;
    eachParam(d, outputs, [&](const Param& p) {
      if (isFirst)
        out += outputs ? "\n| output | type | meaning |\n|---|---|---|\n"
                       : "\n| parameter | type | default | range | meaning |\n|---|---|---|---|---|\n";
      isFirst = false;
      const std::string help = cell(std::string(p.doc ? p.doc : "") + (outputs ? "" : notesOf(p)));
      out += outputs ? fmt::format("| `{}` | {} | {} |\n", p.name, typeOf(p), help)
                     : fmt::format("| `{}` | {} | {} | {} | {} |\n", p.name, typeOf(p), cell(defaultOf(p)),
                                   cell(rangeOf(p)), help);
    });
  }
  return out + "\nMade by `kinora plugins " + d.name + " --markdown`; [all plug-ins](../plugins.md).\n";
}

// Patterns that only hand on integers have nothing to show.
bool hasPicture(const Descriptor& d) {
  if (d.kind != Kind::Pattern) return d.kind != Kind::Display;
  bool shows = false;
  eachParam(d, true, [&](const Param& p) { shows = shows || p.type != Type::Int; });
  return shows;
}

}  // namespace kinora::app
