#[cfg(test)]
mod tests {
    use double_pendulum as p;
    use thrown_stone as s;

    #[test]
    fn what_cannot_be_is_said() {
        let wrong = p::Parameters { m1: -1.0, ..Default::default() };
        assert_eq!(p::Model::new(&wrong).err().unwrap().to_string(), "m1 is outside its bounds");
        let nobody = p::Settings { method: "nobody".into(), ..Default::default() };
        assert!(p::Motion::new(&Default::default(), &nobody).err().unwrap().to_string().contains("no such method"));
        let verlet = p::Settings { method: "verlet".into(), step: 0.1, ..Default::default() };
        assert!(p::Motion::new(&Default::default(), &verlet).err().unwrap().to_string().contains("verlet"));
    }

    #[test]
    fn times_that_are_none_are_said() {
        let settings = p::Settings { rtol: 0.0, ..Default::default() };
        assert!(p::Motion::new(&Default::default(), &settings).err().unwrap().to_string().contains("rtol"));
        let mut motion = p::Motion::new(&Default::default(), &Default::default()).unwrap();
        motion.to(1.0).unwrap();
        for (t, said) in [(f64::NAN, "finite"), (f64::INFINITY, "finite"), (-1.0, "before"), (0.5, "before")] {
            assert!(motion.to(t).err().unwrap().to_string().contains(said));
        }
        assert_eq!((motion.to(1.0), motion.t()), (Ok(true), 1.0));
    }

    #[test]
    fn threads_have_their_own() {
        let one = |m1: f64| {
            let mut motion = p::Motion::new(&p::Parameters { m1, ..Default::default() }, &Default::default()).unwrap();
            motion.to(5.0).unwrap();
            (motion.q()[0], motion.energy())
        };
        let all: Vec<_> = (1..9).map(|k| std::thread::spawn(move || one(k as f64))).collect();
        for (k, thread) in all.into_iter().enumerate() {
            assert_eq!(thread.join().unwrap(), one(k as f64 + 1.0));
        }
    }

    #[test]
    fn an_event_ends_it() {
        let mut stone = s::Motion::new(&Default::default(), &Default::default()).unwrap();
        assert_eq!(stone.to(1e3), Ok(false));
        let found = stone.crossings();
        assert_eq!(s::EVENTS[found.last().unwrap().event].name, "ground");
        assert!(stone.t() > 0.1 && stone.t() < 100.0);
    }
}
