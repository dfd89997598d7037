//! Joint values from the command line.

use dcd_robot::Robot;

/// `1,2,…` for all moved joints, or `name=1,…` for some, the others as they are `otherwise`; what is
/// wrong, in words.
pub(super) fn parse(
    text: &str,
    robot: &Robot,
    otherwise: &[(String, f64)],
) -> Result<Vec<f64>, String> {
    let fields: Vec<&str> = text.split(',').map(str::trim).collect();
    if fields.iter().any(|field| field.contains('=')) {
        let named = fields.iter().enumerate().map(|(index, field)| match field.split_once('=') {
            Some((name, value)) => Ok((name.trim().to_owned(), number(index, value)?)),
            None => Err(format!("value {index} is {field:?}, without a joint's name")),
        });
        let named = named.collect::<Result<Vec<_>, _>>()?;
        let state = robot.state(&[otherwise, &named[..]].concat());
        let state = state.map_err(|error| error.to_string())?;
        return each_counts(&named, robot).map(|()| state);
    }
    let joints = robot.variables();
    if fields.len() != joints.len() {
        return Err(format!(
            "{} values, but {} joints move: {}",
            fields.len(),
            joints.len(),
            joints.join(", ")
        ));
    }
    fields.iter().enumerate().map(|(index, field)| number(index, field)).collect()
}

/// Refuses a value that another one, or the joint itself, would leave without a meaning.
fn each_counts(named: &[(String, f64)], robot: &Robot) -> Result<(), String> {
    for (index, (name, _)) in named.iter().enumerate() {
        if named[..index].iter().any(|(before, _)| before == name) {
            return Err(format!("there are two values of {name:?}"));
        }
        if !robot.variables().contains(name) {
            let values = robot.variables().join(", ");
            return Err(format!("joint {name:?} has no value of that name; there are {values}"));
        }
    }
    Ok(())
}

fn number(index: usize, text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(value) => Err(format!("value {index} is {value}, not a finite number")),
        Err(_) => Err(format!("value {index} is {text:?}, no number")),
    }
}
