//! Whether an SPDX licence expression lets anyone use a crate in any product.

/// Licences that let it, as SPDX names them. MPL-2.0 covers only the files it stands in.
const PERMISSIVE: [&str; 15] = [
    "0BSD",
    "Apache-2.0",
    "BSD-1-Clause",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "CC0-1.0",
    "ISC",
    "MIT",
    "MIT-0",
    "MPL-2.0",
    "Unicode-3.0",
    "Unlicense",
    "Zlib",
    // A BSD licence with the name of the library that it was written for.
    "bzip2-1.0.6",
];

/// Whether some choice that `expression` offers needs only permissive licences.
///
/// An expression that cannot be read is not permissive. A `/` between two names is the old form of
/// `OR`; an exception (`WITH`) only ever permits more.
#[must_use]
pub fn is_permissive(expression: &str) -> bool {
    let spaced = expression.replace('/', " OR ").replace('(', " ( ").replace(')', " ) ");
    let mut words = spaced.split_whitespace().peekable();
    any(&mut words) == Some(true) && words.next().is_none()
}

type Words<'a> = std::iter::Peekable<std::str::SplitWhitespace<'a>>;

/// Alternatives joined by OR, which binds loosest.
fn any(words: &mut Words) -> Option<bool> {
    let mut permissive = all(words)?;
    while words.next_if_eq(&"OR").is_some() {
        permissive |= all(words)?;
    }
    Some(permissive)
}

fn all(words: &mut Words) -> Option<bool> {
    let mut permissive = one(words)?;
    while words.next_if_eq(&"AND").is_some() {
        permissive &= one(words)?;
    }
    Some(permissive)
}

fn one(words: &mut Words) -> Option<bool> {
    match words.next()? {
        "(" => {
            let permissive = any(words)?;
            (words.next()? == ")").then_some(permissive)
        }
        ")" | "AND" | "OR" | "WITH" => None,
        name => {
            if words.next_if_eq(&"WITH").is_some() {
                words.next()?;
            }
            Some(PERMISSIVE.contains(&name))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_permissive_choice_is_enough() {
        for expression in [
            "MIT",
            "MIT OR Apache-2.0",
            "MIT/Apache-2.0",
            "GPL-3.0-only OR MIT",
            "(MIT OR Apache-2.0) AND Unicode-3.0",
            "Apache-2.0 WITH LLVM-exception OR MIT",
        ] {
            assert!(is_permissive(expression), "{expression}");
        }
    }

    #[test]
    fn what_every_choice_forbids_or_nobody_can_read_is_refused() {
        for expression in [
            "",
            "GPL-3.0-only",
            "MIT AND GPL-3.0-only",
            "(MIT OR Apache-2.0) AND LGPL-3.0-only",
            "MIT OR",
            "(MIT",
            "MIT)",
            "MIT Apache-2.0",
            "AND MIT",
            "Apache-2.0 WITH",
        ] {
            assert!(!is_permissive(expression), "{expression}");
        }
    }
}
