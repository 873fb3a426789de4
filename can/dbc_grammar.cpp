#include "can/dbc_grammar.h"

#include <algorithm>
#include <boost/fusion/include/adapt_struct.hpp>
#include <boost/spirit/home/x3.hpp>
#include <cstddef>
#include <cstdio>
#include <type_traits>
#include <utility>

BOOST_FUSION_ADAPT_STRUCT(hystcan::can::dbc::SignalLine, name, multiplexing, start_bit, length, byte_order,
                          sign, scale, offset, minimum, maximum, unit, receivers)
BOOST_FUSION_ADAPT_STRUCT(hystcan::can::dbc::MessageBlock, id, name, length, sender, signals)
BOOST_FUSION_ADAPT_STRUCT(hystcan::can::dbc::MessageComment, id, text)
BOOST_FUSION_ADAPT_STRUCT(hystcan::can::dbc::SignalComment, id, signal, text)
BOOST_FUSION_ADAPT_STRUCT(hystcan::can::dbc::ValueName, raw, name)
BOOST_FUSION_ADAPT_STRUCT(hystcan::can::dbc::SignalValues, id, signal, names)
BOOST_FUSION_ADAPT_STRUCT(hystcan::can::dbc::SignalValueType, id, signal, type)

namespace hystcan::can::dbc {
namespace {

namespace x3 = boost::spirit::x3;

/// A parser with the words in which an error asks for it. '%' stands for the message or signal being read.
template <class Subject>
struct Wanted : x3::unary_parser<Subject, Wanted<Subject>> {
  using Base = x3::unary_parser<Subject, Wanted<Subject>>;
  static constexpr bool is_pass_through_unary = true;
  static constexpr bool handles_container = Subject::handles_container;

  constexpr Wanted(const Subject& wrapped, const char* its_words) : Base(wrapped), words(its_words) {}

  template <class Iterator, class Context, class RuleContext, class Attribute>
  bool parse(Iterator& first, const Iterator& last, const Context& context, RuleContext& rule_context,
             Attribute& attribute) const {
    return this->subject.parse(first, last, context, rule_context, attribute);
  }

  const char* words;
};

template <class Parser>
constexpr auto wanted(const Parser& parser, const char* words) {
  return Wanted<typename x3::extension::as_parser<Parser>::value_type>(x3::as_parser(parser), words);
}

}  // namespace
}  // namespace hystcan::can::dbc

template <class Subject>
struct boost::spirit::x3::get_info<hystcan::can::dbc::Wanted<Subject>> {
  using result_type = std::string;
  std::string operator()(const hystcan::can::dbc::Wanted<Subject>& parser) const { return parser.words; }
};

namespace hystcan::can::dbc {
namespace {

// ---- tokens
// -----------------------------------------------------------------------------------------------------

const auto blank = x3::char_(" \t\r\n\f\v");
const auto digit = x3::char_("0-9");
const auto word_start = x3::char_("a-zA-Z_");
const auto word_part = x3::char_("a-zA-Z0-9_");
const auto sign = x3::char_("+-");

const auto keep = [](auto& context) {
  if constexpr (std::is_same_v<std::remove_cvref_t<decltype(x3::_val(context))>, Token>) {
    const auto& range = x3::_attr(context);
    x3::_val(context).text = {range.begin(), static_cast<std::size_t>(range.end() - range.begin())};
  }
};

template <class Parser>
auto token(const Parser& parser) {
  return x3::rule<struct TokenRule, Token>{"token"} = x3::raw[x3::lexeme[parser]][keep];
}

auto keyword(const char* text) { return x3::lexeme[x3::lit(text) >> !word_part]; }

struct SkippedSections : x3::symbols<x3::unused_type> {
  SkippedSections() {
    add("BA_DEF_")("BA_DEF_DEF_")("BA_")("BA_DEF_REL_")("BA_REL_")("BA_DEF_DEF_REL_")("BA_SGTYPE_")(
        "BA_DEF_SGTYPE_")("BU_SG_REL_")("BU_EV_REL_")("BU_BO_REL_")("EV_")("EV_DATA_")("ENVVAR_DATA_")(
        "BO_TX_BU_")("SIG_GROUP_")("SG_MUL_VAL_")("SGTYPE_")("SGTYPE_VAL_")("SIG_TYPE_REF_")(
        "SIGTYPE_VALTYPE_")("CAT_DEF_")("CAT_")("FILTER");
  }
};
const SkippedSections skipped_sections;

const auto reserved = x3::lexeme[(x3::omit[skipped_sections] | "VERSION" | "NS_" | "BS_" | "BU_" | "BO_" |
                                  "SG_" | "CM_" | "VAL_TABLE_" | "VAL_" | "SIG_VALTYPE_") >>
                                 !word_part];
const auto after_new_symbols =
    keyword("VERSION") | keyword("NS_") | keyword("BS_") | keyword("BU_") | keyword("BO_");

const auto word = token(word_start >> *word_part);
const auto name = token((word_start >> *word_part) - reserved);
const auto natural = token(+digit);
const auto integer = token(-sign >> +digit);
const auto number =
    token(-sign >> (+digit >> -('.' >> *digit) | '.' >> +digit) >> -(x3::char_("eE") >> -sign >> +digit));
const auto quoted = x3::rule<struct QuotedRule, Token>{"string"} =
    x3::lexeme['"' >> x3::raw[*("\\\"" | ~x3::char_('"'))][keep] >> '"'];

// ---- sections
// ---------------------------------------------------------------------------------------------------

struct Subject {
  std::string phrase = "the file";
};

template <const char* const& Kind>
struct NameOf {
  template <class Iterator, class Context>
  void on_success(const Iterator&, const Iterator&, Token& attribute, const Context& context) {
    x3::get<Subject>(context).phrase = Kind + std::string(attribute.text);
  }
};
constexpr const char* message_kind = "message ";
constexpr const char* signal_kind = "signal ";

const auto message_name = x3::rule<NameOf<message_kind>, Token>{"message name"} = word;
const auto signal_name = x3::rule<NameOf<signal_kind>, Token>{"signal name"} = word;

const auto message_id = wanted(natural, "the identifier of a message");
const auto named_signal = wanted(signal_name, "the name of a signal");
const auto colon = wanted(x3::lit(':'), "':' after the section's name");
const auto semicolon = wanted(x3::lit(';'), "';' at the end of the section");
const auto text = wanted(quoted, "a text in quotes");

const auto version = keyword("VERSION") > wanted(quoted, "the version in quotes");
const auto new_symbols = keyword("NS_") > colon > x3::omit[*(word - after_new_symbols)];
const auto bit_timing =
    keyword("BS_") > colon > x3::omit[-(natural > wanted(x3::lit(':'), "':' after the bit rate") >
                                        wanted(natural, "a bit timing register") >
                                        wanted(x3::lit(','), "',' between the bit timing registers") >
                                        wanted(natural, "a bit timing register"))];
const auto nodes = x3::rule<struct NodesRule, std::vector<Token>>{"nodes"} = keyword("BU_") > colon > *name;

const auto multiplexing = token(('M' | ('m' >> +digit >> -x3::lit('M'))) >> !word_part);
const auto signal_line = x3::rule<struct SignalRule, SignalLine>{"signal"} =
    keyword("SG_") > wanted(signal_name, "the name of a signal") > -multiplexing >
    wanted(x3::lit(':'), "':' after the name of %") > wanted(natural, "the start bit of %") >
    wanted(x3::lit('|'), "'|' in the bit position of %") > wanted(natural, "the length of % in bits") >
    wanted(x3::lit('@'), "'@' before the byte order of %") >
    wanted(token(x3::char_("01")), "0 (big-endian) or 1 (little-endian) as the byte order of %") >
    wanted(token(sign), "'+' (unsigned) or '-' (signed) as the value type of %") >
    wanted(x3::lit('('), "'(' before the scale of %") > wanted(number, "the scale of %, a number") >
    wanted(x3::lit(','), "',' between scale and offset of %") > wanted(number, "the offset of %, a number") >
    wanted(x3::lit(')'), "')' after the offset of %") > wanted(x3::lit('['), "'[' before the range of %") >
    wanted(number, "the minimum of %, a number") > wanted(x3::lit('|'), "'|' in the range of %") >
    wanted(number, "the maximum of %, a number") > wanted(x3::lit(']'), "']' after the range of %") >
    wanted(quoted, "the unit of % in quotes") > -(name % ',');
const auto message_block = x3::rule<struct MessageRule, MessageBlock>{"message"} =
    keyword("BO_") > message_id > wanted(message_name, "the name of a message") >
    wanted(x3::lit(':'), "':' after the name of %") > wanted(natural, "the length of % in bytes") >
    wanted(name, "the sender of %") > *signal_line;

const auto message_comment = x3::rule<struct MessageCommentRule, MessageComment>{"comment"} =
    keyword("BO_") > message_id > text;
const auto signal_comment = x3::rule<struct SignalCommentRule, SignalComment>{"comment"} =
    keyword("SG_") > message_id > named_signal > text;
const auto other_comment =
    x3::omit[(keyword("BU_") | keyword("EV_")) > wanted(word, "a name") > text] | x3::omit[quoted];

const auto value_name = x3::rule<struct ValueRule, ValueName>{"value"} = integer > text;
const auto signal_values = x3::rule<struct ValuesRule, SignalValues>{"values"} =
    natural > named_signal > *value_name;
const auto other_values = x3::omit[wanted(word, "the identifier of a message") > *value_name];
const auto value_type = x3::rule<struct ValueTypeRule, SignalValueType>{"value type"} =
    message_id > named_signal > -x3::lit(':') > wanted(natural, "the value type of %, 0 to 3");

const auto skipped = x3::lexeme[x3::omit[skipped_sections] >> !word_part] >
                     x3::omit[*(quoted | (x3::char_ - x3::char_(";\"")))] > semicolon;

template <class Item>
auto into(std::vector<Item> Document::*list) {
  return
      [list](auto& context) { (x3::get<Document>(context).*list).push_back(std::move(x3::_attr(context))); };
}
const auto keep_version = [](auto& context) { x3::get<Document>(context).version = x3::_attr(context); };
const auto keep_nodes = [](auto& context) {
  auto& known = x3::get<Document>(context).nodes;
  known.insert(known.end(), x3::_attr(context).begin(), x3::_attr(context).end());
};

const auto comment = keyword("CM_") >
                     wanted(message_comment[into(&Document::message_comments)] |
                                signal_comment[into(&Document::signal_comments)] | other_comment,
                            "BO_, SG_, BU_, EV_ or a comment in quotes") > semicolon;
const auto values = keyword("VAL_") > (signal_values[into(&Document::values)] | other_values) > semicolon;
const auto value_table = keyword("VAL_TABLE_") >
                         wanted(word, "the name of a value table") > x3::omit[*value_name] > semicolon;
const auto value_types = keyword("SIG_VALTYPE_") > value_type[into(&Document::value_types)] > semicolon;

const auto section = version[keep_version] | message_block[into(&Document::messages)] | comment | values |
                     x3::omit[value_table] | value_types | nodes[keep_nodes] | new_symbols | bit_timing |
                     skipped;
const auto document = x3::eps > wanted(+section, "a DBC, which begins with VERSION, NS_, BS_, BU_ or BO_") >
                      wanted(x3::eoi, "a section of a DBC, such as BO_, CM_ or VAL_");

// ---- errors
// -----------------------------------------------------------------------------------------------------

bool is_word_part(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}

std::string describe(const char* at, const char* end) {
  if (at == end) return "the end of the file";
  if (*at == '"' && std::find(at + 1, end, '"') == end) return "a string without an end";
  if (is_word_part(*at)) {
    const char* word_end = std::find_if_not(at, std::min(at + 40, end), is_word_part);
    return '\'' + std::string(at, word_end) + '\'';
  }
  if (*at >= ' ' && *at <= '~') return std::string("'") + *at + '\'';
  char byte[12];
  std::snprintf(byte, sizeof byte, "byte 0x%02X", static_cast<unsigned>(static_cast<unsigned char>(*at)));
  return byte;
}

std::string with_subject(std::string words, const std::string& subject) {
  const auto place = words.find('%');
  return place == std::string::npos ? words : words.replace(place, 1, subject);
}

const char* skip_blanks(const char* at, const char* end) {
  return std::find_if_not(
      at, end, [](char c) { return std::string_view(" \t\r\n\f\v").find(c) != std::string_view::npos; });
}

}  // namespace

Document parse_document(std::string_view input) {
  Document result;
  Subject subject;
  const char* first = input.data();
  const char* const last = first + input.size();
  try {
    const auto grammar = x3::with<Document>(result)[x3::with<Subject>(subject)[document]];
    x3::phrase_parse(first, last, grammar, blank);
  } catch (const x3::expectation_failure<const char*>& failure) {
    const char* where = skip_blanks(failure.where(), last);
    throw Mistake{where, describe(where, last), with_subject(failure.which(), subject.phrase)};
  }
  return result;
}

}  // namespace hystcan::can::dbc
