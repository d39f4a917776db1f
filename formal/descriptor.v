(* From the numbers of a proof file to the poles of a plant in descriptor form. *)
From Coq Require Import ZArith QArith.
From mathcomp Require Import all_ssreflect all_algebra ssrZ zify ring.
From formal Require Export numbers.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* E x' = A x + B u with u = K x. *)
Record descriptor := Descriptor { E_ : numbers; A_ : numbers; B_ : numbers }.

(* Its pencil times d e: d makes the plant whole, e the gain. *)
Definition loop_E (d e : Z) (v : descriptor) : entries := times e (whole d (E_ v)).
Definition loop_A m (d e : Z) (K : numbers) (v : descriptor) : entries :=
  plus (times e (whole d (A_ v))) (mul m (whole d (B_ v)) (whole e K)).
Definition descriptor_whole (vs : seq descriptor) (K : numbers) (d e : Z) : bool :=
  [&& Z.ltb 0 d, Z.ltb 0 e, is_whole e K
    & all (fun v => [&& is_whole d (E_ v), is_whole d (A_ v) & is_whole d (B_ v)]) vs].
Definition descriptor_pencils N m (vs : seq descriptor) (K : numbers) (d e : Z) :=
  [seq (memo N N (loop_E d e v), memo N N (loop_A m d e K v)) | v <- vs].

(* What is said: for all weights w >= 0 whose sum is one the matrix E of the mean plant
   is regular, and each motion x e^(s t) has its s in the place R. *)
Definition descriptor_poles_in N m (vs : seq descriptor) (K : numbers)
    (R : place) : Prop :=
  forall (C : numClosedFieldType) (w : 'I_(size vs) -> C),
  (forall i, 0 <= w i) -> \sum_i w i = 1 ->
  let no := Descriptor [::] [::] [::] in
  let E := mean no w N N E_ in let A := mean no w N N A_ in
  let B := mean no w N m B_ in
  \det E != 0 /\
  forall s (x : 'cV[C]_N), x != 0 ->
    s *: (E *m x) = A *m x + B *m (real C m N K *m x) ->
    R C s.

Theorem descriptor_sound N m vs K (R : place) d e :
  descriptor_whole vs K d e -> decided N R (descriptor_pencils N m vs K d e) ->
  descriptor_poles_in N m vs K R.
Proof.
move=> /and4P[d0 e0 wK /(all_nthP (Descriptor [::] [::] [::])) each] known.
move=> C w w0 w1 no E A B; set pencils := descriptor_pencils _ _ _ _ _ _ in known.
have [regular poles] := known C _ w (size_map _ _) w0 w1.
have c0 : phi C (Z.mul d e) != 0 by rewrite phiM mulf_neq0 ?lt0r_neq0 ?phi_gt0.
have eE : E_mean N pencils w = phi C (Z.mul d e) *: E.
  rewrite /E /mean scaler_sumr; apply: eq_bigr => i _.
  have /and3P[wE _ _] := each i (ltn_ord i).
  rewrite /region.E_ (nth_map no) //= mx_memo mx_times mx_whole // phiM.
  by rewrite !scalerA; congr (_ *: _); ring.
have eA : A_mean N pencils w = phi C (Z.mul d e) *: (A + B *m real C m N K).
  rewrite /A /B /mean mulmx_suml -big_split scaler_sumr; apply: eq_bigr => i _ /=.
  have /and3P[_ wA wB] := each i (ltn_ord i).
  rewrite /region.A_ (nth_map no) //= mx_memo mx_plus mx_times mx_mul !mx_whole // phiM.
  rewrite -!scalemxAl -scalemxAr !scalerDr !scalerA.
  by congr (_ *: _ + _ *: _); ring.
split.
  by move: regular; rewrite eE detZ; apply: contraNN => /eqP->; rewrite mulr0.
move=> s x x0 motion; apply: poles; apply: (det0_right x0); rewrite eE eA mulmxBl -!scalemxAl mulmxDl -mulmxA -motion.
by rewrite scalerA mulrC -scalerA subrr.
Qed.
