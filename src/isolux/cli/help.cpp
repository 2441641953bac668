#include "isolux/cli/help.h"

#include <iostream>

#include "isolux/scene/option_value.h"

namespace isolux {
namespace {

constexpr const char* kForms =
    "Lists are key=value joined by commas; vectors and colours are three numbers joined by "
    "colons,\n"
    "such as at=0:0:57. Colours are linear. Lengths are in mm in world space (LPS: +x to the\n"
    "patient's left, +y to posterior, +z to superior). Angles are in degrees.\n";

constexpr const char* kInputs =
    "An INPUT is a DICOM folder or file, NIfTI (.nii, .nii.gz, .hdr/.img), NRRD or NHDR,\n"
    "MetaImage (.mha, .mhd), a VTK image (.vti), an InVesalius project (.inv3), a TIFF of several\n"
    "pages or a folder of TIFFs, a folder, zip or tar with one of these, headerless raw with\n"
    "--dims and --type, a built-in volume: phantom:head, phantom:sphere, phantom:marschner-lobb,\n"
    "each also with ,size=N; or a mesh: OBJ, PLY, STL, glTF. The format is found by content.\n"
    "Without INPUT: a real CT head.\n";

std::string sentence_of(const Option& option) {
  std::string text = option.sentence;
  if (!option.unit.empty()) text += ", in " + option.unit;
  if (!option.default_text.empty()) text += " (default " + option.default_text + ")";
  if (option.repeatable) text += "; may be given several times";
  if (!option.not_yet.empty()) text += " [" + option.not_yet + "]";
  return text;
}

std::string value_name(const Option& option) {
  if (option.type == ValueType::kRecord)
    return option.kind_first ? "KIND,key=value,..." : "key=value,...";
  if (option.name == "output") return "OUT.{png,exr}";
  if (option.name == "pixel") return "X,Y";
  if (option.name == "max-memory") return "SIZE";
  if (option.name == "series") return "NUMBER|UID";
  if (option.name == "peers-in" || option.name == "pictures") return "DIR";
  if (option.name == "as-peer") return "NAME";
  if (option.name == "crop") return "I0:J0:K0,I1:J1:K1";
  return option.type == ValueType::kText ? "FILE" : value_pattern(option);
}

std::string option_head(const Option& option) {
  const std::string value = value_name(option);
  const std::string flag = option.name == "output" ? "-o, --output" : "--" + option.name;
  return flag + (value.empty() ? "" : " " + value);
}

std::string field_head(const Option& record, const Option& field) {
  const bool bare = record.kind_first && &field == &record.fields[0];
  return (bare ? "" : field.name + "=") + value_pattern(field);
}

void append_options(std::string& text, const std::vector<Option>& options) {
  for (const Option& option : options) {
    text += "  " + option_head(option) + "\n        " + sentence_of(option) + "\n";
    for (const Option& field : option.fields) {
      text += "          " + field_head(option, field) + "  " + sentence_of(field) + "\n";
    }
  }
}

std::string usage_line(const Command& command) {
  std::string line = "isolux " + command.name;
  if (!command.inputs.empty()) line += " " + command.inputs;
  if (!all_options(command).empty()) line += " [OPTION...]";
  return line;
}

}  // namespace

std::string program_help() {
  std::string text =
      "isolux lights the surfaces in CT and MR scans: ambient, Lambert and Phong, exactly.\n\n"
      "Usage: isolux COMMAND [INPUT...] [OPTION...]\n\nCommands:\n";
  for (const Command& command : commands()) {
    std::string name = command.name;
    name.resize(10, ' ');
    text += "  " + name + command.sentence + "\n";
  }
  return text + "\n" + kInputs +
         "\n`isolux COMMAND --help` shows a command's options and examples.\n";
}

std::string command_help(const Command& command) {
  std::string text = usage_line(command) + "\n\n" + command.sentence + ".\n\n";
  if (!command.inputs.empty()) text += std::string(kInputs) + "\n";
  if (!command.options.empty()) {
    text += "Options:\n";
    append_options(text, command.options);
  }
  if (command.takes_scene) {
    text += "\nThe scene (also the keys of a scene file):\n";
    append_options(text, scene_options());
    text += "\n" + std::string(kForms);
  }
  if (!command.examples.empty()) text += "\nExamples:\n";
  for (const Example& example : command.examples) {
    text += "  # " + example.sentence + "\n  " + example.command + "\n";
  }
  return text;
}

namespace {

std::string in_cell(std::string text) {
  for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) {
    text.replace(at, 1, "\\|");
  }
  return text;
}

void append_table(std::string& text, const std::vector<Option>& options) {
  text += "| option | meaning |\n| --- | --- |\n";
  for (const Option& option : options) {
    text += "| `" + in_cell(option_head(option)) + "` | " + in_cell(sentence_of(option)) + " |\n";
    for (const Option& field : option.fields) {
      text += "| &nbsp;&nbsp;`" + in_cell(field_head(option, field)) + "` | " +
              in_cell(sentence_of(field)) + " |\n";
    }
  }
}

}  // namespace

std::string manual() {
  std::string text =
      "# isolux: the manual page\n\n"
      "Written by `isolux manual`, from the table of options that the program itself reads.\n\n" +
      std::string(kInputs) + "\n" + kForms +
      "\nExit status: 0 done; 1 the work could not be done (unreadable or damaged input, no "
      "memory,\n"
      "cannot write); 2 the command was wrong. On 1 and 2 the last line on standard error is\n"
      "`isolux: error: WHAT: WHY; HINT`.\n";
  for (const Command& command : commands()) {
    text +=
        "\n## " + command.name + "\n\n`" + usage_line(command) + "`: " + command.sentence + ".\n";
    if (!command.options.empty()) {
      text += "\n";
      append_table(text, command.options);
    }
    if (command.takes_scene) text += "\nAll scene options below go with it.\n";
    if (!command.examples.empty()) text += "\n```sh\n";
    for (const Example& example : command.examples) {
      text += "# " + example.sentence + "\n" + example.command + "\n";
    }
    if (!command.examples.empty()) text += "```\n";
  }
  text +=
      "\n## Scene options\n\n"
      "In a scene file these are the keys, with numbers and lists in place of texts: "
      "`{\"isolux_scene\": 1, \"input\": [\"phantom:head\"], \"size\": [512, 512], \"light\": "
      "[{\"kind\": \"point\", \"at\": [0, 0, 57]}]}`. Unknown keys are errors.\n\n";
  append_table(text, scene_options());
  return text;
}

int run_manual(const Command&, const Arguments&) {
  std::cout << manual();
  return 0;
}

}  // namespace isolux
