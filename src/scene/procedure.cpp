#include "stylet/scene/procedure.hpp"

#include "stylet/scene/block.hpp"
#include "stylet/scene/schema_needle.hpp"

#include <algorithm>

namespace stylet {

namespace {

using Row = ProcedureRow;

struct RowEntry {
  std::string name;
  Row::Kind kind;
  Codec<Row> codec;
};

const std::vector<RowEntry>& row_entries() {
  static const std::vector<RowEntry> entries = {
      {"enter", Row::Kind::enter, wrap(&Row::needle, held_needle_codec())},
      {"move", Row::Kind::move,
       block<Row>(
           {field("speed", &Row::speed, number("m/s", anything), "Of the tip.").required(),
            field("duration", &Row::duration, number("s", positive), "Of all steps.").required(),
            field("steps", &Row::steps, integer(1), "As many were solved.").required()})},
      {"implant", Row::Kind::implant,
       block<Row>({field("target", &Row::target, text("a target"), "Where the seed should be.")})},
      {"change", Row::Kind::change,
       block<Row>(
           {field("key", &Row::key, path("a key that changes in mid-run"), "What.").required(),
            field("value", &Row::value, plain(anything), "In SI.").required()})},
      {"undo", Row::Kind::undo,
       block<Row>({field("rows", &Row::rows, integer(0), "That remain.").required()})}};
  return entries;
}

std::string names() {
  std::string all;
  for (const RowEntry& entry : row_entries()) all += (all.empty() ? "" : ", ") + entry.name;
  return all;
}

Row read_row(const Node& node) {
  if (node.kind != Node::Kind::map || node.children.size() != 1) refuse(node, "one of " + names());
  const Node& child = node.children.front();
  const auto& entries = row_entries();
  const auto entry = std::ranges::find(entries, child.key, &RowEntry::name);
  if (entry == entries.end()) refuse(child, "one of " + names());
  Row row{entry->kind};
  entry->codec.read(child, row);
  return row;
}

}  // namespace

std::vector<ProcedureRow> read_procedure(const std::string& file_name,
                                         const std::string& text,
                                         std::string& note) {
  note.clear();
  const std::size_t whole = text.rfind('\n') + 1;  // npos + 1 is 0
  if (whole < text.size()) {
    note = file_name + ": its last row was not written to its end, and is left out";
  }
  const Node document = parse_yaml(file_name, text.substr(0, whole));
  std::vector<Row> rows;
  if (document.kind == Node::Kind::null) return rows;
  if (document.kind != Node::Kind::list) refuse(document, "a list of rows: " + names());
  for (const Node& node : document.children) {
    Row row = read_row(node);
    if (row.kind != Row::Kind::undo) {
      rows.push_back(std::move(row));
      continue;
    }
    const auto remaining = static_cast<std::size_t>(row.rows);
    if (remaining > rows.size()) {
      refuse(node.children.front(),
             "undo of rows that there are, here " + std::to_string(rows.size()) + " at most");
    }
    rows.resize(remaining);
  }
  int n_entered = 0;
  for (Row& row : rows) {
    if (row.kind != Row::Kind::enter) continue;
    ++n_entered;
    if (row.needle.name.empty()) row.needle.name = "needle" + std::to_string(n_entered);
  }
  return rows;
}

std::string to_line(const ProcedureRow& row) {
  const auto& entries = row_entries();
  const auto entry = std::ranges::find(entries, row.kind, &RowEntry::kind);
  Node node = Node::map();
  node.add(entry->codec.write(row), entry->name);
  return "- " + yaml_line(node) + "\n";
}

}  // namespace stylet
