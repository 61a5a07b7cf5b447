//! HTML that is well-formed XML as well. What goes in is escaped: there is no other way in.

/// A piece of it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Html(String);

impl Html {
    /// A text. Characters that XML does not have become U+FFFD.
    pub(super) fn text(text: impl std::fmt::Display) -> Self {
        let mut escaped = String::new();
        for c in text.to_string().chars() {
            match c {
                '<' => escaped.push_str("&lt;"),
                '>' => escaped.push_str("&gt;"),
                '&' => escaped.push_str("&amp;"),
                '"' => escaped.push_str("&quot;"),
                '\t' | '\n' | ' '..'\u{7f}' | '\u{a0}'..='\u{fffd}' | '\u{10000}'.. => escaped.push(c),
                _ => escaped.push('\u{fffd}'),
            }
        }
        Self(escaped)
    }

    /// An element with attributes, and what is in it.
    pub(super) fn element(
        name: &'static str,
        attributes: &[(&'static str, &str)],
        content: impl IntoIterator<Item = Self>,
    ) -> Self {
        let mut element = format!("<{name}");
        for (attribute, value) in attributes {
            let Self(value) = Self::text(value);
            element.extend([" ", attribute, "=\"", &value, "\""]);
        }
        let Self(content) = content.into_iter().collect();
        if ["img", "meta"].contains(&name) {
            element.push_str("/>");
        } else {
            element.extend([">", &content, "</", name, ">"]);
        }
        Self(element)
    }

    /// An element that has a text alone.
    pub(super) fn of(name: &'static str, text: impl std::fmt::Display) -> Self {
        Self::element(name, &[], [Self::text(text)])
    }

    /// A table: a row of heads, and rows of cells.
    pub(super) fn table(heads: &[&str], rows: impl IntoIterator<Item = Vec<Self>>) -> Self {
        let head = heads.iter().map(|head| Self::element("th", &[("scope", "col")], [Self::text(head)]));
        let head = Self::element("thead", &[], [Self::element("tr", &[], head)]);
        let row = |cells: Vec<Self>| {
            Self::element("tr", &[], cells.into_iter().map(|cell| Self::element("td", &[], [cell])))
        };
        let body = Self::element("tbody", &[], rows.into_iter().map(row));
        let head = if heads.is_empty() { Self::default() } else { head };
        Self::element("div", &[("class", "wide")], [Self::element("table", &[], [head, body])])
    }

    /// Names and what they stand for.
    pub(super) fn list(items: impl IntoIterator<Item = (String, Self)>) -> Self {
        let item = |(name, value)| [Self::of("dt", name), Self::element("dd", &[], [value])];
        Self::element("dl", &[], items.into_iter().flat_map(item))
    }

    /// A whole document with a style sheet, which is ours and has nothing to escape.
    pub(super) fn document(title: &str, style: &'static str, body: impl IntoIterator<Item = Self>) -> String {
        debug_assert!(!style.contains(['<', '&']), "XML would read it as markup");
        let head = [
            Self::element("meta", &[("charset", "utf-8")], []),
            Self::element("meta", &[("name", "viewport"), ("content", "width=device-width")], []),
            Self::of("title", title),
            Self::element("style", &[], [Self(style.into())]),
        ];
        let content = [Self::element("head", &[], head), Self::element("body", &[], body)];
        let Self(html) = Self::element("html", &[("lang", "en")], content);
        format!("<!DOCTYPE html>\n{html}\n")
    }
}

impl FromIterator<Html> for Html {
    fn from_iter<I: IntoIterator<Item = Html>>(pieces: I) -> Self {
        Self(pieces.into_iter().map(|Html(piece)| piece).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_goes_in_comes_out_as_text() {
        let text = "<script>alert(\"a&b\")</script> ½ \u{1d707}\n";
        let body = [Html::element("p", &[("title", text)], [Html::text(text)])];
        let document = Html::document(text, "p { color: red }", body);
        let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
        let read = roxmltree::Document::parse_with_options(&document, options).unwrap();
        let find = |name| read.descendants().find(|node| node.has_tag_name(name)).unwrap();
        assert_eq!((find("p").text(), find("title").text()), (Some(text), Some(text)));
        assert!(read.descendants().all(|node| !node.has_tag_name("script")));
        // An attribute's line ends are spaces in XML.
        assert_eq!(find("p").attribute("title").unwrap(), text.replace('\n', " "));
    }

    #[test]
    fn what_xml_lacks_is_replaced() {
        assert_eq!(Html::text("a\0b\u{1b}[0m\u{ffff}"), Html("a\u{fffd}b\u{fffd}[0m\u{fffd}".into()));
    }

    #[test]
    fn tables_and_lists_have_their_parts() {
        let table = Html::table(&["a", "b"], [vec![Html::text(1), Html::text(2)]]);
        assert!(table.0.contains("<th scope=\"col\">b</th>") && table.0.contains("<td>2</td>"));
        assert!(!Html::table(&[], [vec![Html::text(1)]]).0.contains("thead"));
        assert_eq!(Html::list([("n".into(), Html::text('v'))]).0, "<dl><dt>n</dt><dd>v</dd></dl>");
    }
}
