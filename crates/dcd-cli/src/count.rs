//! Numbers of things on the command line: refused beyond what can be meant, with what they would take.

use std::ops::RangeInclusive;

/// Objects: a u32 counts them.
pub(crate) fn objects(text: &str) -> Result<u32, String> {
    // An object takes 500 bytes and more.
    within(text, 0..=u32::MAX.into(), ("objects", 500.0)).map(|n| n as u32)
}

/// Frames of a capture; each has a pose an object, 104 bytes.
pub(crate) fn frames(text: &str) -> Result<u32, String> {
    within(text, 1..=u32::MAX.into(), ("frames of one object", 104.0)).map(|n| n as u32)
}

/// Threads; each has a stack of two megabytes.
pub(crate) fn threads(text: &str) -> Result<u16, String> {
    within(text, 1..=1024, ("threads", 2e6)).map(|n| n as u16)
}

/// Repeats; each leaves five times of sixteen bytes.
pub(crate) fn repeats(text: &str) -> Result<u32, String> {
    within(text, 1..=1_000_000, ("repeats", 80.0)).map(|n| n as u32)
}

fn within(
    text: &str,
    range: RangeInclusive<u64>,
    (what, bytes): (&str, f64),
) -> Result<u64, String> {
    let refused = |count: f64| {
        let (low, high) = (range.start(), range.end());
        let mut message = format!("{text} is not in {low}..={high}");
        if count > *high as f64 {
            message += &format!("; {count:e} {what} would take about {:.1e} bytes", count * bytes);
        }
        message
    };
    match (text.parse::<u64>(), text.parse::<f64>()) {
        (Ok(count), _) if range.contains(&count) => Ok(count),
        (Ok(count), _) => Err(refused(count as f64)),
        (_, Ok(count)) if text.bytes().all(|byte| byte.is_ascii_digit()) => Err(refused(count)),
        _ => Err("no whole number of at least 0".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absurd_counts_are_refused_with_an_estimate_and_others_are_taken() {
        assert_eq!((objects("0"), threads("1024")), (Ok(0), Ok(1024)));
        assert_eq!((repeats("1000000"), frames("4294967295")), (Ok(1_000_000), Ok(u32::MAX)));
        let refused = objects("1000000000000").unwrap_err();
        assert!(refused.ends_with("1e12 objects would take about 5.0e14 bytes"), "{refused}");
        let refused = threads("99999999999999999999999").unwrap_err();
        assert!(refused.contains("1e23 threads would take about 2.0e29 bytes"), "{refused}");
        assert_eq!(repeats("0").unwrap_err(), "0 is not in 1..=1000000");
        for text in ["-1", "1.5", "1e3", "", "many", "NaN", "inf"] {
            assert!(objects(text).unwrap_err().starts_with("no whole number"), "{text}");
        }
    }
}
